#include "roomwise/guide/obstacle.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace roomwise::guide {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kStride_px = 4;  // every 16th pixel: at a metre they are 8 mm apart
constexpr double kBin_m = 0.02;
constexpr std::ptrdiff_t kWindow = 5;  // bins
// A camera that looks up or down by more than 60 degrees sees the floor or the ceiling.
constexpr double kMinForward = 0.5;

}  // namespace

Expected<void> WalkingCorridor::validate() const {
  if (!(half_width_m > 0)) return fail("half_width_m is {}; expected more than 0", half_width_m);
  if (!(highest_m > lowest_m && lowest_m >= 0)) {
    return fail("lowest_m is {} and highest_m {}; expected 0 or more, and more", lowest_m,
                highest_m);
  }
  if (!(farthest_m >= nearest_m + kBin_m && nearest_m >= 0 && farthest_m <= 10)) {
    return fail("nearest_m is {} and farthest_m {}; expected 0 or more, and more up to 10",
                nearest_m, farthest_m);
  }
  if (!(min_area_m2 > 0)) return fail("min_area_m2 is {}; expected more than 0", min_area_m2);
  if (!(std::abs(up_camera.norm() - 1) < 1e-6)) {
    return fail("up_camera has the length {}; expected 1", up_camera.norm());
  }
  return {};
}

Expected<std::optional<double>> obstacle_ahead_m(const image::DepthImage& depth,
                                                 const geometry::PinholeCamera& camera,
                                                 const WalkingCorridor& corridor) {
  ROOMWISE_CHECK_OK(corridor.validate());
  if (depth.width() != camera.width || depth.height() != camera.height) {
    return fail("the depth image has {}x{} pixels; the camera {}x{}", depth.width(), depth.height(),
                camera.width, camera.height);
  }
  const Vector3d& up = corridor.up_camera;
  const Vector3d level = Vector3d::UnitZ() - up.z() * up;
  if (level.norm() < kMinForward) return std::nullopt;
  const Vector3d forward = level.normalized();
  const Vector3d right = forward.cross(up);

  // How much surface is seen at each distance.
  std::vector<double> area_m2(
      static_cast<std::size_t>((corridor.farthest_m - corridor.nearest_m) / kBin_m + 1e-9));
  const double pixels = kStride_px * kStride_px / (camera.fx * camera.fy);
  for (int y = kStride_px / 2; y < depth.height(); y += kStride_px) {
    for (int x = kStride_px / 2; x < depth.width(); x += kStride_px) {
      if (depth.at(x, y) == 0) continue;
      const double depth_m = depth.at(x, y) / camera.depth_units_per_metre;
      // The lens distorts by millimetres here.
      const Vector3d point = camera.unproject_undistorted(Vector2d(x, y), depth_m);
      const double height_m = corridor.camera_height_m + up.dot(point);
      const double ahead_m = forward.dot(point);
      const auto bin = static_cast<std::ptrdiff_t>((ahead_m - corridor.nearest_m) / kBin_m);
      if (std::abs(right.dot(point)) > corridor.half_width_m || height_m < corridor.lowest_m ||
          height_m > corridor.highest_m || ahead_m < corridor.nearest_m ||
          bin >= std::ssize(area_m2)) {
        continue;
      }
      area_m2[static_cast<std::size_t>(bin)] += pixels * depth_m * depth_m;
    }
  }
  for (auto bin = area_m2.begin(); bin != area_m2.end(); ++bin) {
    const auto end = bin + std::min(kWindow, area_m2.end() - bin);
    if (*bin > 0 && std::accumulate(bin, end, 0.0) >= corridor.min_area_m2) {
      return corridor.nearest_m + kBin_m * static_cast<double>(bin - area_m2.begin());
    }
  }
  return std::nullopt;
}

Prompt hazard_prompt(double distance_m, const Wording& wording, TimestampNs now_ns) {
  Prompt prompt = make_prompt(
      wording, "hazard", "hazard.ahead", {}, Confidence::kSure, after(now_ns, kHazardValid_s),
      fmt::format("the depth camera sees something {:.2f} m ahead", distance_m));
  prompt.priority = Priority::kHazard;
  prompt.sound = Sound::kAlert;
  return prompt;
}

}  // namespace roomwise::guide
