#include "roomwise/live/recording/frame_images.h"

#include <cmath>

#include "roomwise/image/codec.h"
#include "roomwise/recording/phone/one_camera.h"

namespace roomwise::live {
namespace {

using geometry::PinholeCamera;

template <typename Image>
Expected<void> check_size(const char* what, const Image& image, int width, int height) {
  if (image.width() == width && image.height() == height) return {};
  return fail("the {} has {} x {} pixels, and {} x {} were told", what, image.width(),
              image.height(), width, height);
}

// Whether no pixel lies farther from its place than features are found exactly.
bool are_as_good_as_same(const PinholeCamera& a, const PinholeCamera& b) {
  if (a.width != b.width || a.height != b.height) return false;
  constexpr double kMost_px = 0.25;
  const auto moves = [](double f, double c, double other_f, double other_c, double at) {
    return std::abs((at - c) / f * other_f + other_c - at) > kMost_px;
  };
  for (const double x : {0.0, a.width - 1.0}) {
    if (moves(a.fx, a.cx, b.fx, b.cx, x)) return false;
  }
  for (const double y : {0.0, a.height - 1.0}) {
    if (moves(a.fy, a.cy, b.fy, b.cy, y)) return false;
  }
  return true;
}

// The camera that took the frame's picture, and the one that it is brought to. Only a frame that
// told of its own camera has two.
struct Cameras {
  PinholeCamera from, to;
};
Expected<Cameras> cameras_of(const CameraFrame& frame, const service::DeviceCamera& camera) {
  PinholeCamera to = camera.calibrated.value_or(PinholeCamera{});
  to.width = camera.width;
  to.height = camera.height;
  if (!frame.camera) return Cameras{to, to};
  if (!camera.calibrated || !to.distortion.is_none()) {
    return fail(
        "the frame tells of its own camera; then the hello's camera needs fx, fy, cx and cy, and "
        "no distortion");
  }
  PinholeCamera from = *frame.camera;
  from.depth_units_per_metre = to.depth_units_per_metre;
  return Cameras{from, to};
}

}  // namespace

Expected<FrameImages> images_of(const CameraFrame& frame, const service::DeviceCamera& camera) {
  ROOMWISE_TRY(const Cameras cameras, cameras_of(frame, camera));
  const auto& [from, to] = cameras;
  // What is a little larger gets a clear error below; what is far larger is not even decoded.
  const std::int64_t max_pixels = 2 * std::int64_t{from.width} * from.height;
  FrameImages images;
  ROOMWISE_TRY(images.color, image::decode_color(frame.color, max_pixels));
  ROOMWISE_RETURN_IF_ERROR(check_size("picture", images.color, from.width, from.height));
  const bool is_same = are_as_good_as_same(from, to);
  if (!is_same) {
    images.color = recording::as_seen_by(images.color, from, to);
    images.color_is_as_sent = false;
  }
  if (frame.depth.empty()) return images;
  if (!camera.has_depth) return fail("a depth image comes from a camera without depth");
  ROOMWISE_TRY(image::DepthImage depth, image::decode_depth(frame.depth, max_pixels));
  const service::ImageSize size =
      frame.depth_size.value_or(service::ImageSize{from.width, from.height});
  ROOMWISE_RETURN_IF_ERROR(check_size("depth image", depth, size.width, size.height));
  images.depth_is_as_sent = is_same && size == service::ImageSize{to.width, to.height};
  images.depth =
      images.depth_is_as_sent
          ? std::move(depth)
          : recording::as_seen_by(depth, recording::in_size(from, size.width, size.height), to);
  return images;
}

}  // namespace roomwise::live
