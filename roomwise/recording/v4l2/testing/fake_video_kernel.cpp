#include "roomwise/recording/v4l2/testing/fake_video_kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

namespace roomwise::recording::testing {
namespace {

constexpr std::uint32_t kOffsetStep = 1U << 20U;  // between the buffers' addresses

bool is_packed(std::uint32_t pixels) {
  return pixels == V4L2_PIX_FMT_MJPEG || pixels == V4L2_PIX_FMT_JPEG;
}
std::uint32_t bytes_of_pixel(std::uint32_t pixels) {
  return pixels == V4L2_PIX_FMT_RGB24 || pixels == V4L2_PIX_FMT_BGR24 ? 3 : 2;
}

template <std::size_t Size>
void put(std::uint8_t (&field)[Size], const std::string& text) {
  std::memcpy(field, text.data(), std::min(text.size(), Size - 1));
}

}  // namespace

void FakeVideoKernel::add(FakeVideoNode node) {
  nodes_.emplace(node.path, std::move(node));
}

FakeVideoNode& FakeVideoKernel::node(const std::string& path) {
  return nodes_.at(path);
}

std::vector<std::string> FakeVideoKernel::devices() {
  std::vector<std::string> paths;
  for (const auto& [path, node] : nodes_) {
    if (!is_gone(node)) paths.push_back(path);
  }
  return paths;
}

int FakeVideoKernel::open(const std::string& path) {
  const auto found = nodes_.find(path);
  if (found == nodes_.end() || is_gone(found->second)) return -ENOENT;
  if (found->second.open_error != 0) return -found->second.open_error;
  open_[next_descriptor_].node = &found->second;
  return next_descriptor_++;
}

void FakeVideoKernel::close(int descriptor) {
  const Open& open = open_.at(descriptor);
  EXPECT_TRUE(std::ranges::none_of(open.buffers, &Buffer::is_mapped)) << "closed while mapped";
  open_.erase(descriptor);
}

int FakeVideoKernel::ioctl(int descriptor, unsigned long request, void* argument) {
  const auto found = open_.find(descriptor);
  if (found == open_.end()) return -EBADF;
  Open& open = found->second;
  const FakeVideoNode& node = *open.node;
  if (is_gone(node)) return -ENODEV;
  switch (request) {
    case VIDIOC_QUERYCAP: {
      auto& says = *static_cast<v4l2_capability*>(argument);
      put(says.card, node.name);
      put(says.bus_info, node.bus);
      // That of all its nodes, and that of this one.
      says.capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING |
                          V4L2_CAP_DEVICE_CAPS;
      says.device_caps = node.capabilities;
      return node.capabilities == 0 ? -ENOTTY : 0;
    }
    case VIDIOC_ENUM_FMT:
      return list_format(open, *static_cast<v4l2_fmtdesc*>(argument));
    case VIDIOC_ENUM_FRAMESIZES:
      return list_size(open, *static_cast<v4l2_frmsizeenum*>(argument));
    case VIDIOC_ENUM_FRAMEINTERVALS:
      return list_interval(open, *static_cast<v4l2_frmivalenum*>(argument));
    case VIDIOC_S_FMT:
      return set_format(open, *static_cast<v4l2_format*>(argument));
    case VIDIOC_S_PARM:
      return set_interval(open, *static_cast<v4l2_streamparm*>(argument));
    case VIDIOC_REQBUFS:
      return request_buffers(open, *static_cast<v4l2_requestbuffers*>(argument));
    case VIDIOC_QUERYBUF:
      return query_buffer(open, *static_cast<v4l2_buffer*>(argument));
    case VIDIOC_QBUF:
      return queue(open, *static_cast<v4l2_buffer*>(argument));
    case VIDIOC_DQBUF:
      return dequeue(open, *static_cast<v4l2_buffer*>(argument));
    case VIDIOC_STREAMON:
      return start(open);
    case VIDIOC_STREAMOFF:
      open.is_streaming = false;
      open.queued.clear();
      open.done.clear();
      return 0;
    default:
      return -ENOTTY;
  }
}

int FakeVideoKernel::list_format(const Open& open, v4l2_fmtdesc& listed) {
  if (listed.index >= open.node->formats.size()) return -EINVAL;
  listed.pixelformat = open.node->formats[listed.index].pixels;
  return 0;
}

int FakeVideoKernel::list_size(const Open& open, v4l2_frmsizeenum& listed) {
  if (!open.node->lists_sizes) return -ENOTTY;
  const auto& formats = open.node->formats;
  const auto format = std::ranges::find(formats, listed.pixel_format, &FakeVideoFormat::pixels);
  if (format == formats.end() || listed.index >= format->sizes.size()) return -EINVAL;
  listed.type = V4L2_FRMSIZE_TYPE_DISCRETE;
  listed.discrete = {format->sizes[listed.index].first, format->sizes[listed.index].second};
  return 0;
}

int FakeVideoKernel::list_interval(const Open& open, v4l2_frmivalenum& listed) {
  if (!open.node->knows_rates) return -ENOTTY;
  const auto& formats = open.node->formats;
  const auto format = std::ranges::find(formats, listed.pixel_format, &FakeVideoFormat::pixels);
  if (format == formats.end() || listed.index >= format->rates_hz.size()) return -EINVAL;
  listed.type = V4L2_FRMIVAL_TYPE_DISCRETE;
  listed.discrete = {1, format->rates_hz[listed.index]};
  return 0;
}

// A driver never refuses a format: it gives the one that is most like it.
int FakeVideoKernel::set_format(Open& open, v4l2_format& format) {
  if (!open.buffers.empty()) return -EBUSY;
  if (open.node->format_error != 0) return -open.node->format_error;
  v4l2_pix_format& pix = format.fmt.pix;
  const auto& formats = open.node->formats;
  auto known = std::ranges::find(formats, pix.pixelformat, &FakeVideoFormat::pixels);
  if (known == formats.end()) known = formats.begin();
  pix.pixelformat = known->pixels;
  std::pair size{pix.width, pix.height};
  if (std::ranges::find(known->sizes, size) == known->sizes.end()) size = known->sizes.front();
  if (open.node->size_given.first != 0) size = open.node->size_given;
  std::tie(pix.width, pix.height) = size;
  // Rows may end with bytes that are no pixels.
  constexpr std::uint32_t kPadding = 6;
  pix.bytesperline =
      is_packed(pix.pixelformat) ? 0 : pix.width * bytes_of_pixel(pix.pixelformat) + kPadding;
  pix.sizeimage = std::max(pix.bytesperline, 2 * pix.width) * pix.height;
  open.format = pix;
  return 0;
}

int FakeVideoKernel::set_interval(Open& open, v4l2_streamparm& parameters) {
  if (!open.node->knows_rates) return -ENOTTY;
  const v4l2_fract& interval = parameters.parm.capture.timeperframe;
  open.node->interval_set = interval;
  open.period_ns = TimestampNs{1'000'000'000} * interval.numerator / interval.denominator;
  return 0;
}

int FakeVideoKernel::request_buffers(Open& open, v4l2_requestbuffers& request) {
  if (open.format.sizeimage == 0 || request.memory != V4L2_MEMORY_MMAP) return -EINVAL;
  if (std::ranges::any_of(open.buffers, &Buffer::is_mapped)) return -EBUSY;
  request.count = std::min(request.count, 32U);
  open.buffers.assign(request.count, {Bytes(open.format.sizeimage), false, {}});
  return 0;
}

int FakeVideoKernel::query_buffer(const Open& open, v4l2_buffer& buffer) {
  if (buffer.index >= open.buffers.size()) return -EINVAL;
  buffer.length = open.format.sizeimage;
  buffer.m.offset = buffer.index * kOffsetStep;
  return 0;
}

int FakeVideoKernel::queue(Open& open, v4l2_buffer& buffer) {
  if (buffer.index >= open.buffers.size()) return -EINVAL;
  const auto is_in = [&](const auto& list) {
    return std::ranges::find(list, buffer.index) != list.end();
  };
  EXPECT_FALSE(is_in(open.queued) || is_in(open.done)) << "given to the driver twice";
  if (is_in(open.queued) || is_in(open.done)) return -EINVAL;
  // Whoever goes on reading it sees that it is the driver's.
  std::ranges::fill(open.buffers[buffer.index].memory, std::uint8_t{0xEE});
  open.queued.push_back(buffer.index);
  return 0;
}

int FakeVideoKernel::dequeue(Open& open, v4l2_buffer& buffer) {
  if (!open.is_streaming) return -EINVAL;
  if (open.done.empty()) return -EAGAIN;
  buffer = open.buffers[open.done.front()].filled;
  open.done.pop_front();
  return 0;
}

int FakeVideoKernel::start(Open& open) const {
  if (open.node->start_error != 0) return -open.node->start_error;
  if (open.buffers.empty()) return -EINVAL;
  open.is_streaming = true;
  open.started_ns = now_ns_;
  return 0;
}

const std::uint8_t* FakeVideoKernel::mmap(int descriptor, std::size_t size, std::uint32_t offset) {
  auto& buffers = open_.at(descriptor).buffers;
  const std::size_t index = offset / kOffsetStep;
  if (index >= buffers.size() || size != buffers[index].memory.size()) return nullptr;
  buffers[index].is_mapped = true;
  return buffers[index].memory.data();
}

void FakeVideoKernel::munmap(const std::uint8_t* memory, std::size_t size) {
  for (auto& [descriptor, open] : open_) {
    for (Buffer& buffer : open.buffers) {
      if (buffer.memory.data() != memory || buffer.memory.size() != size) continue;
      EXPECT_TRUE(buffer.is_mapped);
      buffer.is_mapped = false;
      return;
    }
  }
  ADD_FAILURE() << "unmapped what is not mapped";
}

// The picture that is due, into the buffer that was given first; dropped where there is none.
void FakeVideoKernel::fill(Open& open) {
  const FakeVideoNode& node = *open.node;
  const std::uint32_t n = open.sequence;
  if (!open.queued.empty() && !node.is_silent) {
    const std::uint32_t index = open.queued.front();
    open.queued.pop_front();
    Buffer& buffer = open.buffers[index];
    Bytes picture = node.picture(n, open.format);
    if (node.cut.contains(n)) picture.resize(picture.size() / 2);
    std::ranges::copy(picture, buffer.memory.begin());
    buffer.filled = {};
    buffer.filled.index = index;
    buffer.filled.sequence = n;
    buffer.filled.bytesused = static_cast<std::uint32_t>(picture.size());
    buffer.filled.flags = node.timestamp_flags;
    if (node.is_all_damaged || node.damaged.contains(n)) {
      buffer.filled.flags |= V4L2_BUF_FLAG_ERROR;
    }
    const TimestampNs time_us = open.next_at_ns() / 1000;
    buffer.filled.timestamp.tv_sec = time_us / 1'000'000;
    buffer.filled.timestamp.tv_usec = time_us % 1'000'000;
    open.done.push_back(index);
  }
  ++open.sequence;
}

void FakeVideoKernel::advance_to(TimestampNs time_ns) {
  for (auto& [descriptor, open] : open_) {
    const TimestampNs end_ns = std::min(time_ns, open.node->unplugged_at_ns - 1);
    while (open.is_streaming && open.next_at_ns() <= end_ns) fill(open);
  }
  now_ns_ = std::max(now_ns_, time_ns);
}

int FakeVideoKernel::poll(std::span<pollfd> waiting, int timeout_ms) {
  if (interrupted_polls_ > 0) {
    --interrupted_polls_;
    return 0;
  }
  const TimestampNs deadline_ns = now_ns_ + TimestampNs{timeout_ms} * 1'000'000;
  for (;;) {
    int ready = 0;
    TimestampNs next_ns = deadline_ns;
    for (pollfd& one : waiting) {
      const Open& open = open_.at(one.fd);
      one.revents = is_gone(*open.node)  ? static_cast<short>(POLLERR | POLLHUP | POLLPRI)
                    : !open.is_streaming ? static_cast<short>(POLLERR)
                    : open.done.empty()  ? static_cast<short>(0)
                                         : static_cast<short>(POLLIN | POLLRDNORM);
      ready += one.revents != 0 ? 1 : 0;
      if (open.is_streaming) next_ns = std::min(next_ns, open.next_at_ns());
      next_ns = std::min(next_ns, open.node->unplugged_at_ns);
    }
    if (ready > 0 || now_ns_ >= deadline_ns) return ready;
    advance_to(next_ns);
  }
}

}  // namespace roomwise::recording::testing
