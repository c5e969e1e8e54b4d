#include "roomwise/objects/instances/door_leaf.h"

#include <algorithm>

namespace roomwise::objects {

bool is_like_a_leaf(const geometry::OrientedBox& box_world, const GroundPlane& level) {
  const Eigen::Vector3d& size_m = box_world.size_m;
  const auto [thin_m, wide_m] = std::minmax(size_m.x(), size_m.y());
  const double top_m = level.height_m(box_world.center()) + size_m.z() / 2;
  return thin_m < 0.2 && wide_m > 0.35 && wide_m < kLeafWidth_m && size_m.z() > 1.1 && top_m > 1.6;
}

}  // namespace roomwise::objects
