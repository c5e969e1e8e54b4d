#pragma once

#include <filesystem>
#include <memory>

#include "roomwise/base/expected.h"
#include "roomwise/image/image.h"
#include "roomwise/image/personal_data.h"

namespace roomwise::recording {

// The pictures of an MP4 or QuickTime file (H.264, HEVC, ...), each by its place in the order in
// which they are shown. Reading one after the other decodes each once; any other order decodes from
// the key picture before.
class VideoFile {
 public:
  // Reads the packets' times, and decodes nothing. Of a file that was cut off the pictures count
  // before which none is missing. Fails, naming the file, where it is no such video or was cut off
  // before its index.
  [[nodiscard]] static Expected<std::unique_ptr<VideoFile>> open(const std::filesystem::path& path);
  ~VideoFile();
  VideoFile(const VideoFile&) = delete;
  VideoFile& operator=(const VideoFile&) = delete;

  [[nodiscard]] std::size_t size() const;
  // What the file says besides its pictures.
  [[nodiscard]] image::PersonalData personal_data() const;
  // place < size(). Fails where it is damaged. Thread-safe, one at a time.
  [[nodiscard]] Expected<image::ColorImage> read(std::size_t place);

 private:
  struct Stream;
  explicit VideoFile(std::unique_ptr<Stream> stream);
  std::unique_ptr<Stream> stream_;
};

}  // namespace roomwise::recording
