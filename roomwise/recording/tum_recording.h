#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "roomwise/recording/association.h"
#include "roomwise/recording/recording.h"

namespace roomwise::recording {

// The images that rgb.txt or depth.txt of a TUM folder lists: a line an image, "timestamp file"
// with the time in seconds, strictly increasing, and the file given relative to the folder; '#'
// begins a comment. A last line without its line end is what a killed recorder leaves: it counts
// only when it is well formed and its file is there. Reading is thread-safe.
class ImageList {
 public:
  // Fails, naming file and line, on a missing or empty list, a malformed line, a time that does not
  // increase, and a file outside the folder.
  [[nodiscard]] static Expected<ImageList> open(const std::filesystem::path& folder,
                                                const std::filesystem::path& list_name);

  [[nodiscard]] std::size_t size() const { return timestamps_ns_.size(); }
  [[nodiscard]] const std::vector<TimestampNs>& timestamps_ns() const { return timestamps_ns_; }
  // The image's file; entry < size().
  [[nodiscard]] const std::filesystem::path& path(std::size_t entry) const { return paths_[entry]; }
  // For errors: where the entry stands ("home/rgb.txt:12") and the same with its file.
  [[nodiscard]] std::string place(std::size_t entry) const;
  [[nodiscard]] std::string describe(std::size_t entry) const;
  // The file as it lies on the disk; the picture in it. They fail, naming the file and its line in
  // the list.
  [[nodiscard]] Expected<Bytes> read(std::size_t entry) const;
  [[nodiscard]] Expected<image::ColorImage> read_color(std::size_t entry) const;

 private:
  std::filesystem::path list_path_;
  std::vector<TimestampNs> timestamps_ns_;
  std::vector<std::filesystem::path> paths_;
  std::vector<std::size_t> lines_;
};

// A recording on disk in the format of the TUM RGB-D benchmark (Sturm et al., "A Benchmark for the
// Evaluation of RGB-D SLAM Systems", IROS 2012): rgb.txt, depth.txt, the images they list, and,
// where the camera is not given by option, camera.txt; odometry.txt (odometry_file.h), where there
// is one, is the device's motion. Colour is PNG or JPEG, depth 16-bit PNG.
class TumRecording final : public Recording {
 public:
  // By rgb.txt and depth.txt in the folder.
  [[nodiscard]] static bool recognises(const std::filesystem::path& folder);
  // Reading fails, naming the image and its line in the list, where an image is missing, truncated,
  // of another size than the camera's, or where depth is no 16-bit greyscale PNG.
  [[nodiscard]] static Expected<std::unique_ptr<TumRecording>> open(
      const std::filesystem::path& folder, const RecordingOptions& options = {});

  // All colour images, with depth or without; RgbdFrame::index counts in this list.
  [[nodiscard]] const ImageList& colors() const { return colors_; }
  // The frames: first is the place in colors(), second that in the list of depth images.
  [[nodiscard]] const std::vector<Association>& associations() const { return associations_; }
  [[nodiscard]] std::string describe(const RecordedPicture& picture) const override;

 private:
  TumRecording(RecordingContents contents, ImageList colors, ImageList depths,
               std::vector<Association> associations);
  [[nodiscard]] Expected<image::RgbdFrame> read_frame(
      const RecordedPicture& picture) const override;
  [[nodiscard]] Expected<image::ColorImage> read_picture(
      const RecordedPicture& picture) const override;
  [[nodiscard]] Expected<Bytes> read_picture_file(const RecordedPicture& picture) const override;

  ImageList colors_;
  ImageList depths_;
  std::vector<Association> associations_;
};

}  // namespace roomwise::recording
