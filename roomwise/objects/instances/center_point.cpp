#include "roomwise/objects/instances/center_point.h"

#include <algorithm>
#include <vector>

#include "roomwise/base/median.h"

namespace roomwise::objects {

std::optional<Eigen::Vector3d> center_point(const image::DepthImage& depth,
                                            const geometry::PinholeCamera& camera) {
  constexpr int kHalfSide = 4;
  constexpr std::size_t kMinMeasured = (2 * kHalfSide + 1) * (2 * kHalfSide + 1) / 4;
  const int center_x = depth.width() / 2;
  const int center_y = depth.height() / 2;
  std::vector<std::uint16_t> measured;
  for (int y = center_y - kHalfSide; y <= center_y + kHalfSide; ++y) {
    for (int x = center_x - kHalfSide; x <= center_x + kHalfSide; ++x) {
      if (depth.contains(x, y) && depth.at(x, y) != 0) measured.push_back(depth.at(x, y));
    }
  }
  if (measured.size() < kMinMeasured) return std::nullopt;
  return camera.unproject({center_x, center_y}, median_of(measured) / camera.depth_units_per_metre);
}

}  // namespace roomwise::objects
