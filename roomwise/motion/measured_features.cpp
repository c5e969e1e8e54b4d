#include "roomwise/motion/measured_features.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace roomwise::motion {
namespace {

// The distance at a pixel, m; 0 where too little was measured, at an edge, or too far away.
double depth_around(const image::DepthImage& depth, const geometry::PinholeCamera& camera, int x,
                    int y, const DepthRange& range) {
  std::array<std::uint16_t, 9> measured;
  measured.fill(std::numeric_limits<std::uint16_t>::max());  // sorted behind what was measured
  std::size_t count = 0;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (!depth.contains(x + dx, y + dy)) continue;
      const std::uint16_t value = depth.at(x + dx, y + dy);
      if (value != 0) measured[count++] = value;
    }
  }
  constexpr std::size_t kMinMeasured = 3;
  if (count < kMinMeasured) return 0;
  std::ranges::sort(measured);
  const double median_m = measured[count / 2] / camera.depth_units_per_metre;
  const double spread_m = (measured[count - 1] - measured[0]) / camera.depth_units_per_metre;
  if (median_m > range.farthest_m || spread_m > range.max_relative_spread * median_m) return 0;
  return median_m;
}

}  // namespace

Expected<void> DepthRange::validate() const {
  if (!(farthest_m > 0)) return fail("farthest_m = {} must be positive", farthest_m);
  if (!(max_relative_spread > 0))
    return fail("max_relative_spread = {} must be positive", max_relative_spread);
  return {};
}

MeasuredFeatures measure_features(features::Features features, const image::DepthImage& depth,
                                  const geometry::PinholeCamera& camera, const DepthRange& range) {
  MeasuredFeatures measured;
  measured.pixels.reserve(features.size());
  measured.points.reserve(features.size());
  for (const features::Keypoint& keypoint : features.keypoints) {
    const Eigen::Vector2d pixel = keypoint.position_px.cast<double>();
    const Eigen::Vector2d undistorted = camera.undistort(pixel);
    const double depth_m = depth_around(depth, camera, static_cast<int>(std::lround(pixel.x())),
                                        static_cast<int>(std::lround(pixel.y())), range);
    measured.pixels.push_back(undistorted);
    measured.points.push_back(camera.unproject_undistorted(undistorted, depth_m));
  }
  measured.features = std::move(features);
  return measured;
}

}  // namespace roomwise::motion
