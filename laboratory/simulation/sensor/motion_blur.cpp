#include "laboratory/simulation/sensor/motion_blur.h"

#include <algorithm>
#include <cmath>

namespace roomwise::simulation {
namespace {

constexpr float kSky_m = 1000;     // where no surface is seen
constexpr float kSharp_px = 0.3F;  // shorter ways are not seen
constexpr float kTapDistance_px = 1.5F;
constexpr int kMaxTaps = 24;

}  // namespace

MotionBlur::MotionBlur(const RenderedFrame& frame, const WalkPose& pose,
                       const geometry::PinholeCamera& camera,
                       const image::Image<Eigen::Vector2f>& rays)
    : frame_(frame),
      radiance_(frame.radiance.width(), frame.radiance.height(), Eigen::Vector4f::Zero()),
      rays_(rays),
      focal_px_(static_cast<float>(camera.fx), static_cast<float>(camera.fy)),
      open_(motion_to(pose.world_from_camera_open, pose)),
      close_(motion_to(pose.world_from_camera_close, pose)) {
  std::ranges::transform(frame.radiance.pixels(), radiance_.pixels().begin(),
                         [](const Eigen::Vector3f& pixel) {
                           return Eigen::Vector4f(pixel.x(), pixel.y(), pixel.z(), 0);
                         });
}

MotionBlur::Motion MotionBlur::motion_to(const geometry::RigidTransform& world_from_end,
                                         const WalkPose& pose) const {
  const geometry::RigidTransform end_from_camera =
      world_from_end.inverse() * pose.world_from_camera;
  return {end_from_camera.rotation_matrix().cast<float>(),
          end_from_camera.translation.cast<float>()};
}

// By how many pixels the point that a pixel sees is displaced at the shutter's end. The lens is
// left out: it changes a way of some pixels by little.
Eigen::Vector2f MotionBlur::shift(const Motion& motion, const Eigen::Vector2f& ray,
                                  float depth_m) const {
  const Eigen::Vector3f point =
      motion.rotation * (depth_m * ray.homogeneous()) + motion.translation;
  if (point.z() <= 0.01F) return Eigen::Vector2f::Zero();  // came from behind the camera
  return focal_px_.cwiseProduct(point.hnormalized() - ray);
}

Eigen::Vector4f MotionBlur::interpolated(const Eigen::Vector2f& pixel) const {
  const float x = std::clamp(pixel.x(), 0.0F, static_cast<float>(radiance_.width() - 1));
  const float y = std::clamp(pixel.y(), 0.0F, static_cast<float>(radiance_.height() - 1));
  const int left = std::min(static_cast<int>(x), std::max(radiance_.width() - 2, 0));
  const int top = std::min(static_cast<int>(y), std::max(radiance_.height() - 2, 0));
  const int right = std::min(left + 1, radiance_.width() - 1);
  const int bottom = std::min(top + 1, radiance_.height() - 1);
  const float u = x - static_cast<float>(left), v = y - static_cast<float>(top);
  return (1 - v) * ((1 - u) * radiance_.at(left, top) + u * radiance_.at(right, top)) +
         v * ((1 - u) * radiance_.at(left, bottom) + u * radiance_.at(right, bottom));
}

Eigen::Vector3f MotionBlur::light_at(int x, int y) const {
  const float seen_m = frame_.depth_m.at(x, y);
  const float depth_m = seen_m > 0 ? seen_m : kSky_m;
  const Eigen::Vector2f& ray = rays_.at(x, y);
  const Eigen::Vector2f open = shift(open_, ray, depth_m), close = shift(close_, ray, depth_m);
  const float way_px = (close - open).norm();
  if (way_px < kSharp_px) return frame_.radiance.at(x, y);
  const int taps = std::min(kMaxTaps, 2 + static_cast<int>(std::ceil(way_px / kTapDistance_px)));
  const Eigen::Vector2f pixel(static_cast<float>(x), static_cast<float>(y));
  Eigen::Vector4f sum = Eigen::Vector4f::Zero();
  for (int tap = 0; tap < taps; ++tap) {
    // When the point has gone by `way`, the pixel sees what lay as far on the other side of it.
    const float time = (static_cast<float>(tap) + 0.5F) / static_cast<float>(taps);
    const Eigen::Vector2f way = (1 - time) * open + time * close;
    sum += interpolated(pixel - way);
  }
  return sum.head<3>() / static_cast<float>(taps);
}

}  // namespace roomwise::simulation
