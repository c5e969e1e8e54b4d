#include "roomwise/recording/v4l2/v4l2_source.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <deque>

#include "roomwise/image/codec.h"
#include "roomwise/recording/phone/one_camera.h"
#include "roomwise/recording/robot/depth_registration.h"
#include "roomwise/recording/robot/pixels.h"
#include "roomwise/recording/robot/working_camera.h"
#include "roomwise/recording/v4l2/video_stream.h"

namespace roomwise::recording {
namespace {

using geometry::PinholeCamera;

constexpr std::array<std::uint32_t, 1> kDepthPixels{V4L2_PIX_FMT_Z16};

// The formats of colour, the best first: what is not packed loses nothing; the names that
// pixels.h has for them, none for a JPEG.
struct ColorPixels {
  std::uint32_t pixels;
  std::string_view name;
};
constexpr std::array kColorPixels{
    ColorPixels{V4L2_PIX_FMT_RGB24, "rgb8"}, ColorPixels{V4L2_PIX_FMT_BGR24, "bgr8"},
    ColorPixels{V4L2_PIX_FMT_YUYV, "YUYV"},  ColorPixels{V4L2_PIX_FMT_UYVY, "UYVY"},
    ColorPixels{V4L2_PIX_FMT_MJPEG, ""},     ColorPixels{V4L2_PIX_FMT_JPEG, ""}};

constexpr auto kColorFormats = [] {
  std::array<std::uint32_t, kColorPixels.size()> formats{};
  for (std::size_t i = 0; i < formats.size(); ++i) formats[i] = kColorPixels[i].pixels;
  return formats;
}();

// Where a driver does not say its rate.
constexpr TimestampNs kUsualPeriodNs = 1'000'000'000 / 30;
// Pictures of a stream that wait for their partners: streams lag behind each other by a frame or
// two.
constexpr std::size_t kMaxWaitingPictures = 4;

std::string described(const VideoNode& node) {
  return fmt::format("{} ({}): {}", node.path, node.name, node.describe_formats());
}

// Every device that is there, or why it cannot be looked at.
std::vector<Expected<VideoNode>> all_nodes(const std::shared_ptr<VideoKernel>& kernel) {
  std::vector<Expected<VideoNode>> nodes;
  for (const std::string& path : kernel->devices()) {
    nodes.push_back(look_at_video_node(kernel, path));
  }
  return nodes;
}

// What was found, for who is told that the right thing was not.
std::string what_is_there(const std::vector<Expected<VideoNode>>& nodes) {
  std::vector<std::string> lines;
  for (const auto& node : nodes) {
    if (!node) {
      lines.push_back(node.error().message);
    } else if (!node->formats.empty()) {
      lines.push_back(described(*node));
    }
  }
  return lines.empty() ? "nothing" : fmt::format("{}", fmt::join(lines, "; "));
}

// Which devices are read.
struct RgbdNodes {
  VideoNode depth, color;
};

Expected<VideoNode> depth_node(const V4l2Options& options,
                               const std::shared_ptr<VideoKernel>& kernel,
                               const std::vector<Expected<VideoNode>>& nodes) {
  if (!options.depth_device.empty()) {
    ROOMWISE_TRY(VideoNode named, look_at_video_node(kernel, options.depth_device));
    if (named.format_of(kDepthPixels) != nullptr) return named;
    return fail("{}; depth is {}. There is: {}", described(named), name_of_pixels(kDepthPixels[0]),
                what_is_there(nodes));
  }
  for (const auto& node : nodes) {
    if (node && node->format_of(kDepthPixels) != nullptr) return *node;
  }
  if (nodes.empty()) {
    return fail(
        "there is no camera (/dev/video*); plug it in, and see that the kernel has its driver "
        "(uvcvideo)");
  }
  return fail("no camera gives depth ({}). There is: {}", name_of_pixels(kDepthPixels[0]),
              what_is_there(nodes));
}

Expected<VideoNode> color_node(const V4l2Options& options,
                               const std::shared_ptr<VideoKernel>& kernel,
                               const std::vector<Expected<VideoNode>>& nodes,
                               const VideoNode& depth) {
  if (!options.color_device.empty()) {
    ROOMWISE_TRY(VideoNode named, look_at_video_node(kernel, options.color_device));
    if (named.format_of(kColorFormats) != nullptr) return named;
    return fail("{}; no colour that is read. There is: {}", described(named), what_is_there(nodes));
  }
  for (const auto& node : nodes) {
    const bool is_beside = node && node->path != depth.path && node->bus == depth.bus;
    if (is_beside && node->format_of(kColorFormats) != nullptr) return *node;
  }
  return fail(
      "{} ({}): no colour comes from the same camera; name its device, too (v4l2:{},/dev/videoN). "
      "There is: {}",
      depth.path, depth.name, depth.path, what_is_there(nodes));
}

Expected<RgbdNodes> find_nodes(const V4l2Options& options,
                               const std::shared_ptr<VideoKernel>& kernel) {
  const std::vector<Expected<VideoNode>> nodes = all_nodes(kernel);
  RgbdNodes found;
  ROOMWISE_TRY(found.depth, depth_node(options, kernel, nodes));
  ROOMWISE_TRY(found.color, color_node(options, kernel, nodes, found.depth));
  if (found.depth.path == found.color.path) {
    return fail("{}: gives one stream at a time; name another device for colour", found.depth.path);
  }
  return found;
}

Expected<VideoMode> mode_of(const VideoNode& node, std::span<const std::uint32_t> pixels,
                            const PinholeCamera& camera, std::string_view what) {
  const auto found = node.pixels_of_size(pixels, camera.width, camera.height);
  if (found) return VideoMode{*found, camera.width, camera.height};
  return fail("{}: gives no {} of {}x{} pixels, for which it is calibrated; it gives {}", node.path,
              what, camera.width, camera.height, node.describe_formats());
}

std::string_view pixel_name(std::uint32_t pixels) {
  const auto* const found = std::ranges::find(kColorPixels, pixels, &ColorPixels::pixels);
  return found == kColorPixels.end() ? "16UC1" : found->name;
}

// The same in pixels.h's words.
ImageMessage message_of(const VideoStream& stream, CapturedPicture picture) {
  ImageMessage message;
  message.width = static_cast<std::uint32_t>(stream.mode().width);
  message.height = static_cast<std::uint32_t>(stream.mode().height);
  message.step = stream.row_bytes();
  message.pixels = pixel_name(stream.mode().pixels);
  message.data = std::move(picture.bytes);
  return message;
}

Expected<image::ColorImage> color_picture(const VideoStream& stream, CapturedPicture picture) {
  if (!pixel_name(stream.mode().pixels).empty()) {
    return color_of(message_of(stream, std::move(picture)));
  }
  ROOMWISE_TRY(image::ColorImage color, image::decode_color(picture.bytes));
  if (color.width() == stream.mode().width && color.height() == stream.mode().height) return color;
  return fail("{}: a picture has {}x{} pixels", stream.node().path(), color.width(),
              color.height());
}

}  // namespace

Expected<void> V4l2Options::validate() const {
  if (!std::isfinite(timeout_s) || timeout_s <= 0 || timeout_s > 3600) {
    return fail("timeout_s = {} must be positive, at most 3600", timeout_s);
  }
  if (!(max_rate_hz >= 1 && max_rate_hz <= 1000)) {
    return fail("max_rate_hz = {} must be 1 to 1000", max_rate_hz);
  }
  if (depth_device.empty() && !color_device.empty()) {
    return fail("colour from {} needs the device of its depth, too", color_device);
  }
  ROOMWISE_RETURN_IF_ERROR(calibration.color.validate());
  if (calibration.depth) ROOMWISE_RETURN_IF_ERROR(calibration.depth->validate());
  return {};
}

// The two open streams.
class V4l2Source::Session {
 public:
  Session(V4l2Options options, std::shared_ptr<VideoKernel> kernel)
      : options_(std::move(options)), kernel_(std::move(kernel)) {}

  [[nodiscard]] Expected<void> open();
  [[nodiscard]] Expected<std::optional<image::RgbdFrame>> next();
  [[nodiscard]] const SourceInfo& info() const { return info_; }

 private:
  struct Stream {
    const char* what;
    std::unique_ptr<VideoStream> video{};
    std::deque<CapturedPicture> waiting{};  // in the order of time
  };

  [[nodiscard]] Expected<void> wait_for_picture(TimestampNs deadline_ns);
  [[nodiscard]] Expected<void> read(Stream& stream, short happened);
  [[nodiscard]] Unexpected too_late() const;
  [[nodiscard]] TimestampNs tolerance_ns() const;
  [[nodiscard]] bool bring_pair_to_front();
  [[nodiscard]] std::optional<image::RgbdFrame> take_front_pair();
  [[nodiscard]] image::DepthImage registered(const image::DepthImage& depth) const;
  void count_lost();

  V4l2Options options_;
  std::shared_ptr<VideoKernel> kernel_;
  WorkingCamera camera_;
  std::optional<DepthRegistration> registration_;
  SourceInfo info_;
  std::uint64_t next_index_ = 0;
  std::uint64_t unreadable_ = 0;
  TimestampNs last_timestamp_ns_ = 0;
  Stream color_{.what = "colour"}, depth_{.what = "depth"};
};

Expected<void> V4l2Source::Session::open() {
  const RgbdCalibration& calibration = options_.calibration;
  const PinholeCamera& depth_camera = calibration.depth.value_or(calibration.color);
  ROOMWISE_TRY(camera_, working_camera(calibration.color, std::nullopt));
  ROOMWISE_TRY(const RgbdNodes nodes, find_nodes(options_, kernel_));
  ROOMWISE_TRY(const VideoMode depth_mode,
               mode_of(nodes.depth, kDepthPixels, depth_camera, "depth"));
  ROOMWISE_TRY(const VideoMode color_mode,
               mode_of(nodes.color, kColorFormats, calibration.color, "colour"));
  ROOMWISE_TRY(depth_.video,
               VideoStream::open(kernel_, nodes.depth.path, depth_mode, options_.max_rate_hz));
  ROOMWISE_TRY(color_.video,
               VideoStream::open(kernel_, nodes.color.path, color_mode, options_.max_rate_hz));
  if (calibration.depth) {
    registration_.emplace(*calibration.depth, camera_.working, calibration.color_from_depth);
  }
  info_.camera = camera_.working;
  info_.name = fmt::format("{} ({}, {})", nodes.depth.name, nodes.depth.path, nodes.color.path);
  ROOMWISE_RETURN_IF_ERROR(depth_.video->start());
  return color_.video->start();
}

Expected<std::optional<image::RgbdFrame>> V4l2Source::Session::next() {
  const TimestampNs deadline_ns =
      kernel_->now_ns() + std::llround(options_.timeout_s / kSecondsPerNs);
  for (;;) {
    if (!bring_pair_to_front()) {
      ROOMWISE_RETURN_IF_ERROR(wait_for_picture(deadline_ns));
      continue;
    }
    auto frame = take_front_pair();
    count_lost();
    if (frame) return frame;
  }
}

// Each stream is read as its pictures come: waiting for one would lose those of the other.
Expected<void> V4l2Source::Session::wait_for_picture(TimestampNs deadline_ns) {
  const TimestampNs left_ns = deadline_ns - kernel_->now_ns();
  if (left_ns <= 0) return too_late();
  constexpr TimestampNs kNsPerMs = 1'000'000;
  std::array<pollfd, 2> waiting{pollfd{color_.video->node().descriptor(), POLLIN, 0},
                                pollfd{depth_.video->node().descriptor(), POLLIN, 0}};
  const int ready = kernel_->poll(waiting, static_cast<int>((left_ns + kNsPerMs - 1) / kNsPerMs));
  if (ready < 0) {
    return fail("{}: cannot be waited for: {}", info_.name, std::strerror(-ready));
  }
  ROOMWISE_RETURN_IF_ERROR(read(color_, waiting[0].revents));
  return read(depth_, waiting[1].revents);
}

Expected<void> V4l2Source::Session::read(Stream& stream, short happened) {
  if (happened == 0) return {};
  const std::uint64_t damaged_before = stream.video->damaged();
  ROOMWISE_TRY(auto picture, stream.video->take());
  if (picture) {
    stream.waiting.push_back(*std::move(picture));
    if (stream.waiting.size() > kMaxWaitingPictures) stream.waiting.pop_front();
    return {};
  }
  const bool is_broken = (happened & (POLLERR | POLLHUP | POLLNVAL)) != 0;
  if (is_broken && stream.video->damaged() == damaged_before) {
    return fail("{}: its driver gives no {} any more; plug the camera in anew",
                stream.video->node().path(), stream.what);
  }
  return {};
}

Unexpected V4l2Source::Session::too_late() const {
  const Stream& missing = color_.waiting.empty() ? color_ : depth_;
  const char* const what =
      color_.waiting.empty() || depth_.waiting.empty() ? missing.what : "matching";
  const std::uint64_t damaged = color_.video->damaged() + depth_.video->damaged() + unreadable_;
  const std::string seen =
      damaged == 0
          ? "see that it is plugged in"
          : fmt::format("{} pictures came damaged so far: try another cable or USB port", damaged);
  return fail("{}: gave no {} picture for {} s; {}", info_.name, what, options_.timeout_s, seen);
}

// Half of the shorter time between two pictures.
TimestampNs V4l2Source::Session::tolerance_ns() const {
  return std::min(color_.video->period_ns().value_or(kUsualPeriodNs),
                  depth_.video->period_ns().value_or(kUsualPeriodNs)) /
         2;
}

// Drops what came before the first two pictures that belong together; false where no two do.
bool V4l2Source::Session::bring_pair_to_front() {
  for (auto color = color_.waiting.begin(); color != color_.waiting.end(); ++color) {
    const auto depth = std::ranges::find_if(depth_.waiting, [&](const CapturedPicture& candidate) {
      return std::abs(color->timestamp_ns - candidate.timestamp_ns) <= tolerance_ns();
    });
    if (depth == depth_.waiting.end()) continue;
    color_.waiting.erase(color_.waiting.begin(), color);
    depth_.waiting.erase(depth_.waiting.begin(), depth);
    return true;
  }
  return false;
}

// Nothing where one of the two cannot be read, or the clock did not go on.
std::optional<image::RgbdFrame> V4l2Source::Session::take_front_pair() {
  CapturedPicture color = std::move(color_.waiting.front());
  CapturedPicture depth = std::move(depth_.waiting.front());
  color_.waiting.pop_front();
  depth_.waiting.pop_front();
  const TimestampNs timestamp_ns = color.timestamp_ns;
  const auto color_image = color_picture(*color_.video, std::move(color));
  const auto depth_image = depth_of(message_of(*depth_.video, std::move(depth)));
  if (!color_image || !depth_image || (next_index_ > 0 && timestamp_ns <= last_timestamp_ns_)) {
    ++unreadable_;
    return std::nullopt;
  }
  last_timestamp_ns_ = timestamp_ns;
  image::RgbdFrame frame;
  frame.index = next_index_++;
  frame.timestamp_ns = timestamp_ns;
  frame.color = camera_.is_recorded_size()
                    ? *color_image
                    : as_seen_by(*color_image, camera_.recorded, camera_.working);
  frame.depth = registered(*depth_image);
  return frame;
}

image::DepthImage V4l2Source::Session::registered(const image::DepthImage& depth) const {
  if (registration_) return registration_->apply(depth);
  return camera_.is_recorded_size() ? depth : as_seen_by(depth, camera_.recorded, camera_.working);
}

// A frame needs both of its pictures.
void V4l2Source::Session::count_lost() {
  const auto lost_of = [](const VideoStream& stream) { return stream.damaged() + stream.missed(); };
  info_.lost_frames = unreadable_ + std::max(lost_of(*color_.video), lost_of(*depth_.video));
}

V4l2Source::V4l2Source(std::unique_ptr<Session> session) : session_(std::move(session)) {}
V4l2Source::~V4l2Source() = default;

Expected<std::unique_ptr<V4l2Source>> V4l2Source::open(const V4l2Options& options,
                                                       std::shared_ptr<VideoKernel> kernel) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  auto session = std::make_unique<Session>(options, std::move(kernel));
  ROOMWISE_RETURN_IF_ERROR(session->open());
  return std::unique_ptr<V4l2Source>(new V4l2Source(std::move(session)));
}

const SourceInfo& V4l2Source::info() const {
  return session_->info();
}

Expected<std::optional<image::RgbdFrame>> V4l2Source::next() {
  return session_->next();
}

std::string describe_video_cameras(const std::shared_ptr<VideoKernel>& kernel) {
  return what_is_there(all_nodes(kernel));
}

}  // namespace roomwise::recording
