#pragma once

#include <linux/videodev2.h>

#include <cerrno>
#include <deque>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "roomwise/base/file.h"
#include "roomwise/recording/v4l2/video_kernel.h"

namespace roomwise::recording::testing {

struct FakeVideoFormat {
  std::uint32_t pixels = 0;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> sizes;
  std::vector<std::uint32_t> rates_hz{30};
};

// A device as a test wants it to be.
struct FakeVideoNode {
  std::string path, name, bus;
  std::vector<FakeVideoFormat> formats;
  std::uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  // Picture n in the format that was set.
  std::function<Bytes(std::uint32_t n, const v4l2_pix_format& format)> picture;
  TimestampNs offset_ns = 0;  // of the first picture from the start
  std::uint32_t timestamp_flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  // What goes wrong.
  std::set<std::uint32_t> damaged;  // pictures that come with the error flag
  std::set<std::uint32_t> cut;      // that come without their end
  bool is_all_damaged = false;      // every one of them
  bool is_silent = false;           // no picture ever comes
  bool knows_rates = true;          // it can be asked and told
  bool lists_sizes = true;          // else it tells them only when a mode is set
  int open_error = 0, format_error = 0, start_error = 0;
  std::pair<std::uint32_t, std::uint32_t> size_given{};  // in place of the one asked for
  TimestampNs unplugged_at_ns = 1'000'000'000'000;
  // What was asked.
  v4l2_fract interval_set{0, 1};
};

// Devices with the manners of uvcvideo and videobuf2: a buffer is the driver's from QBUF to DQBUF,
// pictures for which it has none are dropped, formats cannot be set while there are buffers, the
// device is gone for every call once it is unplugged. Time passes by poll() and pass() alone. What
// no program may do (take a buffer twice, unmap what is not mapped) fails the test.
class FakeVideoKernel final : public VideoKernel {
 public:
  void add(FakeVideoNode node);
  [[nodiscard]] FakeVideoNode& node(const std::string& path);
  // As if the program were busy with something else.
  void pass(TimestampNs time_ns) { advance_to(now_ns_ + time_ns); }
  // The next calls of poll() are interrupted by a signal.
  void interrupt_polls(int count) { interrupted_polls_ = count; }
  // All that was opened is closed, all that was mapped unmapped.
  [[nodiscard]] bool is_clean() const { return open_.empty(); }

  std::vector<std::string> devices() override;
  int open(const std::string& path) override;
  void close(int descriptor) override;
  int ioctl(int descriptor, unsigned long request, void* argument) override;
  const std::uint8_t* mmap(int descriptor, std::size_t size, std::uint32_t offset) override;
  void munmap(const std::uint8_t* memory, std::size_t size) override;
  int poll(std::span<pollfd> waiting, int timeout_ms) override;
  TimestampNs now_ns() override { return now_ns_; }

 private:
  struct Buffer {
    Bytes memory;
    bool is_mapped = false;
    v4l2_buffer filled{};
  };
  struct Open {
    FakeVideoNode* node = nullptr;
    v4l2_pix_format format{};
    TimestampNs period_ns = 1'000'000'000 / 30;
    std::vector<Buffer> buffers;
    std::deque<std::uint32_t> queued, done;
    bool is_streaming = false;
    TimestampNs started_ns = 0;
    std::uint32_t sequence = 0;  // of the next picture

    [[nodiscard]] TimestampNs next_at_ns() const {
      return started_ns + node->offset_ns + TimestampNs{sequence} * period_ns;
    }
  };
  [[nodiscard]] bool is_gone(const FakeVideoNode& node) const {
    return now_ns_ >= node.unplugged_at_ns;
  }
  void advance_to(TimestampNs time_ns);
  static void fill(Open& open);

  static int list_format(const Open& open, v4l2_fmtdesc& listed);
  static int list_size(const Open& open, v4l2_frmsizeenum& listed);
  static int list_interval(const Open& open, v4l2_frmivalenum& listed);
  static int set_format(Open& open, v4l2_format& format);
  static int set_interval(Open& open, v4l2_streamparm& parameters);
  static int request_buffers(Open& open, v4l2_requestbuffers& request);
  static int query_buffer(const Open& open, v4l2_buffer& buffer);
  static int queue(Open& open, v4l2_buffer& buffer);
  static int dequeue(Open& open, v4l2_buffer& buffer);
  int start(Open& open) const;

  std::map<std::string, FakeVideoNode> nodes_;
  std::map<int, Open> open_;
  int next_descriptor_ = 3;
  int interrupted_polls_ = 0;
  TimestampNs now_ns_ = 7'000'000'000;
};

}  // namespace roomwise::recording::testing
