#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "roomwise/base/file.h"
#include "roomwise/image/image.h"

namespace roomwise::recording {

// The files of a recording of Record3D: of one zip, or of a folder. Errors name the file.
// Thread-safe.
class Record3dFiles {
 public:
  virtual ~Record3dFiles() = default;

  [[nodiscard]] virtual const char* kind() const = 0;
  // Of the zip or the folder.
  [[nodiscard]] virtual const std::filesystem::path& path() const = 0;
  [[nodiscard]] virtual std::string name_of_metadata() const = 0;
  [[nodiscard]] virtual std::string name_of_color(std::size_t frame) const = 0;

  [[nodiscard]] virtual bool has_color(std::size_t frame) const = 0;
  [[nodiscard]] virtual bool has_depth(std::size_t frame) const = 0;
  [[nodiscard]] virtual Expected<Bytes> read_metadata() const = 0;
  [[nodiscard]] virtual Expected<Bytes> read_color(std::size_t frame) const = 0;
  // In metres; 0 where the phone doubts it. Fails where it has not this size.
  [[nodiscard]] virtual Expected<image::Image<float>> read_depth_m(std::size_t frame, int width,
                                                                   int height) const = 0;
};

// An .r3d: metadata, rgbd/0.jpg, .depth (LZFSE) and, of LiDARs, .conf (LZFSE).
[[nodiscard]] Expected<std::unique_ptr<Record3dFiles>> open_record3d_zip(
    const std::filesystem::path& path);

// The folder EXR_RGBD of the export "EXR + JPG", or the one that it lies in: metadata.json,
// rgb/0.jpg (or .png), depth/0.exr. `folder` must be one by find_record3d_folder().
[[nodiscard]] std::unique_ptr<Record3dFiles> open_record3d_exr(const std::filesystem::path& folder);
// The folder that holds metadata.json; an empty path where there is none.
[[nodiscard]] std::filesystem::path find_record3d_folder(const std::filesystem::path& folder);

}  // namespace roomwise::recording
