#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "roomwise/base/file.h"
#include "roomwise/recording/v4l2/video_node.h"

namespace roomwise::recording {

// What a stream is asked to give.
struct VideoMode {
  std::uint32_t pixels = 0;  // V4L2_PIX_FMT_...
  int width = 0, height = 0;
};

// A picture as the driver gave it.
struct CapturedPicture {
  TimestampNs timestamp_ns = 0;  // of the system's monotonic clock
  Bytes bytes;
};

// A stream of pictures from a device: buffers that are shared with the driver, filled by it, copied
// here and given back at once, so that it always has some to fill.
class VideoStream {
 public:
  // Sets the mode, at the fastest rate of at most `max_rate_hz`; where there is none so slow, at
  // the slowest. Fails where the driver gives another mode, or the device is in use.
  [[nodiscard]] static Expected<std::unique_ptr<VideoStream>> open(
      std::shared_ptr<VideoKernel> kernel, const std::string& path, const VideoMode& mode,
      double max_rate_hz);
  ~VideoStream();
  VideoStream(const VideoStream&) = delete;
  VideoStream& operator=(const VideoStream&) = delete;

  [[nodiscard]] Expected<void> start();
  [[nodiscard]] const OpenVideoNode& node() const { return node_; }
  [[nodiscard]] const VideoMode& mode() const { return mode_; }
  // Bytes from row to row; 0 where pictures are compressed.
  [[nodiscard]] std::uint32_t row_bytes() const { return row_bytes_; }
  // Between two pictures; absent where the driver does not say.
  [[nodiscard]] std::optional<TimestampNs> period_ns() const { return period_ns_; }

  // The next picture that is there; nothing where none is, or one that came damaged. Fails where
  // the device is gone.
  [[nodiscard]] Expected<std::optional<CapturedPicture>> take();
  // Pictures that came damaged, and such as the driver had no buffer for.
  [[nodiscard]] std::uint64_t damaged() const { return damaged_; }
  [[nodiscard]] std::uint64_t missed() const { return missed_; }

 private:
  struct Buffer {
    const std::uint8_t* memory = nullptr;
    std::size_t size = 0;
  };
  VideoStream(OpenVideoNode node, const VideoMode& mode) : node_(std::move(node)), mode_(mode) {}
  [[nodiscard]] Expected<void> set_mode();
  void set_rate(double max_rate_hz);
  [[nodiscard]] Expected<void> map_buffers();
  [[nodiscard]] Expected<void> give_back(std::uint32_t index) const;
  [[nodiscard]] Expected<std::optional<CapturedPicture>> copy(const v4l2_buffer& filled);
  void count_missed(std::uint32_t sequence);

  OpenVideoNode node_;
  VideoMode mode_;
  std::uint32_t row_bytes_ = 0;
  std::optional<TimestampNs> period_ns_;
  std::vector<Buffer> buffers_;
  bool is_streaming_ = false;
  std::optional<std::uint32_t> last_sequence_;
  std::uint64_t damaged_ = 0, missed_ = 0;
};

}  // namespace roomwise::recording
