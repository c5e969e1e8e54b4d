#include "roomwise/recording/v4l2/video_stream.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <utility>

namespace roomwise::recording {
namespace {

constexpr std::uint32_t kCapture = V4L2_BUF_TYPE_VIDEO_CAPTURE;
// Some, so that the driver never waits while pictures are decoded; few, so that none is old.
constexpr std::uint32_t kBuffers = 4;
constexpr std::uint32_t kMaxRates = 256;

double seconds_of(const v4l2_fract& interval) {
  return interval.denominator == 0 ? 0 : 1.0 * interval.numerator / interval.denominator;
}

// The time between pictures that is asked for: the shortest that is not below `min_s`; where all
// are, the longest.
v4l2_fract interval_of(const OpenVideoNode& node, const VideoMode& mode, double min_s) {
  constexpr double kRounding = 1e-3;
  std::optional<v4l2_fract> best;
  for (std::uint32_t i = 0; i < kMaxRates; ++i) {
    v4l2_frmivalenum listed{};
    listed.index = i;
    listed.pixel_format = mode.pixels;
    listed.width = static_cast<std::uint32_t>(mode.width);
    listed.height = static_cast<std::uint32_t>(mode.height);
    if (node.ask(VIDIOC_ENUM_FRAMEINTERVALS, listed) != 0) break;
    if (listed.type != V4L2_FRMIVAL_TYPE_DISCRETE) break;
    const double seconds = seconds_of(listed.discrete);
    if (!(seconds > 0)) continue;
    const double before = best ? seconds_of(*best) : 0;
    const bool is_slow_enough = seconds >= min_s * (1 - kRounding);
    const bool was_slow_enough = before >= min_s * (1 - kRounding);
    const bool is_better = is_slow_enough && was_slow_enough ? seconds < before : seconds > before;
    if (!best || is_better) best = listed.discrete;
  }
  return best.value_or(v4l2_fract{1, static_cast<std::uint32_t>(std::lround(1 / min_s))});
}

TimestampNs time_of(const v4l2_buffer& buffer) {
  return TimestampNs{buffer.timestamp.tv_sec} * 1'000'000'000 +
         TimestampNs{buffer.timestamp.tv_usec} * 1000;
}

v4l2_buffer buffer_of(std::uint32_t index) {
  v4l2_buffer buffer{};
  buffer.type = kCapture;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.index = index;
  return buffer;
}

}  // namespace

Expected<std::unique_ptr<VideoStream>> VideoStream::open(std::shared_ptr<VideoKernel> kernel,
                                                         const std::string& path,
                                                         const VideoMode& mode,
                                                         double max_rate_hz) {
  ROOMWISE_TRY(OpenVideoNode node, OpenVideoNode::open(std::move(kernel), path));
  std::unique_ptr<VideoStream> stream(new VideoStream(std::move(node), mode));
  ROOMWISE_RETURN_IF_ERROR(stream->set_mode());
  stream->set_rate(max_rate_hz);
  ROOMWISE_RETURN_IF_ERROR(stream->map_buffers());
  return stream;
}

VideoStream::~VideoStream() {
  std::uint32_t type = kCapture;
  if (is_streaming_) static_cast<void>(node_.ask(VIDIOC_STREAMOFF, type));
  for (const Buffer& buffer : buffers_) node_.kernel().munmap(buffer.memory, buffer.size);
}

Expected<void> VideoStream::set_mode() {
  v4l2_format format{};
  format.type = kCapture;
  format.fmt.pix.width = static_cast<std::uint32_t>(mode_.width);
  format.fmt.pix.height = static_cast<std::uint32_t>(mode_.height);
  format.fmt.pix.pixelformat = mode_.pixels;
  format.fmt.pix.field = V4L2_FIELD_NONE;
  if (const int answer = node_.ask(VIDIOC_S_FMT, format); answer != 0) {
    return node_.failed("does not take its format", -answer);
  }
  const v4l2_pix_format& got = format.fmt.pix;
  if (got.pixelformat != mode_.pixels || std::cmp_not_equal(got.width, mode_.width) ||
      std::cmp_not_equal(got.height, mode_.height)) {
    return fail("{}: gives {} {}x{} where {} {}x{} was asked for", node_.path(),
                name_of_pixels(got.pixelformat), got.width, got.height,
                name_of_pixels(mode_.pixels), mode_.width, mode_.height);
  }
  row_bytes_ = got.bytesperline;
  return {};
}

// A device that cannot be told a rate keeps its own.
void VideoStream::set_rate(double max_rate_hz) {
  v4l2_streamparm asked{};
  asked.type = kCapture;
  asked.parm.capture.timeperframe = interval_of(node_, mode_, 1 / max_rate_hz);
  if (node_.ask(VIDIOC_S_PARM, asked) != 0) return;
  const double period_s = seconds_of(asked.parm.capture.timeperframe);
  if (period_s > 0) period_ns_ = std::llround(period_s / kSecondsPerNs);
}

Expected<void> VideoStream::map_buffers() {
  v4l2_requestbuffers request{};
  request.count = kBuffers;
  request.type = kCapture;
  request.memory = V4L2_MEMORY_MMAP;
  if (const int answer = node_.ask(VIDIOC_REQBUFS, request); answer != 0) {
    return node_.failed("gives no buffers", -answer);
  }
  for (std::uint32_t i = 0; i < request.count; ++i) {
    v4l2_buffer buffer = buffer_of(i);
    if (const int answer = node_.ask(VIDIOC_QUERYBUF, buffer); answer != 0) {
      return node_.failed("gives no buffers", -answer);
    }
    const std::uint8_t* const memory =
        node_.kernel().mmap(node_.descriptor(), buffer.length, buffer.m.offset);
    if (memory == nullptr) return node_.failed("shares no memory", ENOMEM);
    buffers_.push_back({memory, buffer.length});
  }
  if (buffers_.empty()) return node_.failed("gives no buffers", ENOMEM);
  return {};
}

Expected<void> VideoStream::give_back(std::uint32_t index) const {
  v4l2_buffer buffer = buffer_of(index);
  if (const int answer = node_.ask(VIDIOC_QBUF, buffer); answer != 0) {
    return node_.failed("takes no buffer", -answer);
  }
  return {};
}

Expected<void> VideoStream::start() {
  for (std::uint32_t i = 0; i < buffers_.size(); ++i) ROOMWISE_RETURN_IF_ERROR(give_back(i));
  std::uint32_t type = kCapture;
  if (const int answer = node_.ask(VIDIOC_STREAMON, type); answer != 0) {
    return node_.failed("does not start", -answer);
  }
  is_streaming_ = true;
  return {};
}

Expected<std::optional<CapturedPicture>> VideoStream::take() {
  v4l2_buffer filled = buffer_of(0);
  if (const int answer = node_.ask(VIDIOC_DQBUF, filled); answer != 0) {
    if (answer == -EAGAIN) return std::optional<CapturedPicture>();
    return node_.failed("gives no picture", -answer);
  }
  if (filled.index >= buffers_.size()) {
    return fail("{}: its driver gives a buffer that is none of its own", node_.path());
  }
  ROOMWISE_TRY(auto picture, copy(filled));
  ROOMWISE_RETURN_IF_ERROR(give_back(filled.index));
  return picture;
}

Expected<std::optional<CapturedPicture>> VideoStream::copy(const v4l2_buffer& filled) {
  count_missed(filled.sequence);
  const Buffer& buffer = buffers_[filled.index];
  const std::size_t needed = std::size_t{row_bytes_} * static_cast<std::size_t>(mode_.height);
  const bool is_whole = (filled.flags & V4L2_BUF_FLAG_ERROR) == 0 && filled.bytesused > 0 &&
                        filled.bytesused <= buffer.size && filled.bytesused >= needed;
  if (!is_whole) {
    ++damaged_;
    return std::optional<CapturedPicture>();
  }
  if ((filled.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) {
    return fail("{}: its pictures have no times of the system's clock, by which they are paired",
                node_.path());
  }
  CapturedPicture picture{time_of(filled), {}};
  picture.bytes.assign(buffer.memory, buffer.memory + filled.bytesused);
  return picture;
}

void VideoStream::count_missed(std::uint32_t sequence) {
  // The difference wraps with the counter; what goes back is another count.
  const std::uint32_t step = last_sequence_ ? sequence - *last_sequence_ : 1;
  constexpr std::uint32_t kBackwards = 1U << 31U;
  if (step > 0 && step < kBackwards) missed_ += step - 1;
  last_sequence_ = sequence;
}

}  // namespace roomwise::recording
