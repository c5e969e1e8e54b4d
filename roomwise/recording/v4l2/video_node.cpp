#include "roomwise/recording/v4l2/video_node.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace roomwise::recording {
namespace {

// A driver that never ends its lists must not keep us here.
constexpr std::uint32_t kMaxListed = 256;

template <std::size_t Size>
std::string text_of_field(const std::uint8_t (&field)[Size]) {
  const auto end = std::find(std::begin(field), std::end(field), 0);
  std::string text(std::begin(field), end);
  std::ranges::replace_if(
      text, [](unsigned char c) { return c < ' ' || c > '~'; }, '?');
  return text;
}

VideoSizes sizes_of(const v4l2_frmsizeenum& listed) {
  if (listed.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
    const auto& one = listed.discrete;
    return {one.width, one.width, 1, one.height, one.height, 1};
  }
  const auto& range = listed.stepwise;
  return {range.min_width,  range.max_width,  std::max(range.step_width, 1U),
          range.min_height, range.max_height, std::max(range.step_height, 1U)};
}

std::vector<VideoSizes> sizes_of(const OpenVideoNode& node, std::uint32_t pixels) {
  std::vector<VideoSizes> sizes;
  for (std::uint32_t i = 0; i < kMaxListed; ++i) {
    v4l2_frmsizeenum listed{};
    listed.index = i;
    listed.pixel_format = pixels;
    if (node.ask(VIDIOC_ENUM_FRAMESIZES, listed) != 0) break;
    sizes.push_back(sizes_of(listed));
    if (listed.type != V4L2_FRMSIZE_TYPE_DISCRETE) break;
  }
  return sizes;
}

// A format that the driver makes of another one in software is as good as any.
std::vector<VideoFormat> formats_of(const OpenVideoNode& node) {
  std::vector<VideoFormat> formats;
  for (std::uint32_t i = 0; i < kMaxListed; ++i) {
    v4l2_fmtdesc listed{};
    listed.index = i;
    listed.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (node.ask(VIDIOC_ENUM_FMT, listed) != 0) break;
    formats.push_back({listed.pixelformat, sizes_of(node, listed.pixelformat)});
  }
  return formats;
}

}  // namespace

Expected<OpenVideoNode> OpenVideoNode::open(std::shared_ptr<VideoKernel> kernel, std::string path) {
  const int descriptor = kernel->open(path);
  if (descriptor >= 0) return OpenVideoNode(std::move(kernel), std::move(path), descriptor);
  switch (-descriptor) {
    case ENOENT:
      return fail("{}: there is no such device; see that the camera is plugged in", path);
    case EACCES:
    case EPERM:
      return fail(
          "{}: you may not use it; add yourself to its group (sudo usermod -aG video NAME) and log "
          "in anew",
          path);
    case EBUSY:
      return fail("{}: another program uses it; close that", path);
    case ENODEV:
    case ENXIO:
      return fail("{}: the camera was unplugged", path);
    default:
      return fail("{}: cannot be opened: {}", path, std::strerror(-descriptor));
  }
}

OpenVideoNode::OpenVideoNode(OpenVideoNode&& other) noexcept
    : kernel_(std::move(other.kernel_)),
      path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)) {}

OpenVideoNode::~OpenVideoNode() {
  if (descriptor_ >= 0) kernel_->close(descriptor_);
}

Unexpected OpenVideoNode::failed(std::string_view doing, int error) const {
  switch (error) {
    case ENODEV:
    case ENXIO:
      return fail("{}: the camera was unplugged", path_);
    case EBUSY:
      return fail("{}: {}: another program uses it; close that", path_, doing);
    case ENOSPC:
      return fail(
          "{}: {}: the USB bus has no room for so many pictures; plug the camera in where it has a "
          "bus of its own (USB 3), or calibrate a smaller size",
          path_, doing);
    default:
      return fail("{}: {}: {}", path_, doing, std::strerror(error));
  }
}

bool VideoSizes::contains(int width, int height) const {
  const auto w = static_cast<std::uint32_t>(width), h = static_cast<std::uint32_t>(height);
  return w >= min_width && w <= max_width && (w - min_width) % step_width == 0 && h >= min_height &&
         h <= max_height && (h - min_height) % step_height == 0;
}

const VideoFormat* VideoNode::format_of(std::span<const std::uint32_t> pixels) const {
  for (const std::uint32_t one : pixels) {
    const auto found = std::ranges::find(formats, one, &VideoFormat::pixels);
    if (found != formats.end()) return &*found;
  }
  return nullptr;
}

std::optional<std::uint32_t> VideoNode::pixels_of_size(std::span<const std::uint32_t> pixels,
                                                       int width, int height) const {
  for (const std::uint32_t one : pixels) {
    const VideoFormat* const format = format_of({&one, 1});
    const auto is_of_size = [&](const VideoSizes& sizes) { return sizes.contains(width, height); };
    if (format == nullptr) continue;
    // A driver that lists no sizes says when the mode is set which it gives.
    if (format->sizes.empty() || std::ranges::any_of(format->sizes, is_of_size)) return one;
  }
  return std::nullopt;
}

std::string VideoNode::describe_formats() const {
  std::string all;
  for (const VideoFormat& format : formats) {
    all += (all.empty() ? "" : "; ") + name_of_pixels(format.pixels);
    std::string_view between = " ";
    for (const VideoSizes& size : format.sizes) {
      all += fmt::format("{}{}x{}", between, size.min_width, size.min_height);
      if (size.max_width != size.min_width || size.max_height != size.min_height) {
        all += fmt::format(" to {}x{}", size.max_width, size.max_height);
      }
      between = ", ";
    }
  }
  return all.empty() ? "no pictures" : all;
}

Expected<VideoNode> look_at_video_node(const std::shared_ptr<VideoKernel>& kernel,
                                       const std::string& path) {
  ROOMWISE_TRY(const OpenVideoNode open, OpenVideoNode::open(kernel, path));
  v4l2_capability says{};
  if (const int answer = open.ask(VIDIOC_QUERYCAP, says); answer != 0) {
    if (answer == -ENODEV) return open.failed("", ENODEV);
    return fail("{}: is no video device", path);
  }
  VideoNode node{path, text_of_field(says.card), text_of_field(says.bus_info), {}};
  const std::uint32_t can =
      (says.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? says.device_caps : says.capabilities;
  // Others give what the camera says beside its pictures.
  constexpr std::uint32_t kNeeded = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  if ((can & kNeeded) == kNeeded) node.formats = formats_of(open);
  return node;
}

std::string name_of_pixels(std::uint32_t pixels) {
  std::string name;
  for (int i = 0; i < 4; ++i) {
    const auto letter = static_cast<char>(pixels >> (8 * i) & 0x7FU);
    name += letter >= ' ' ? letter : '?';
  }
  while (name.ends_with(' ')) name.pop_back();
  return name;
}

}  // namespace roomwise::recording
