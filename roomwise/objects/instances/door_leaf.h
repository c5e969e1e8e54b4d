#pragma once

#include "roomwise/geometry/oriented_box.h"
#include "roomwise/objects/instances/instances.h"

namespace roomwise::objects {

constexpr double kLeafWidth_m = 1.2;  // at most

// Whether something upright is as tall, wide and thin as a door's leaf, or a good part of one.
[[nodiscard]] bool is_like_a_leaf(const geometry::OrientedBox& box_world, const GroundPlane& level);

}  // namespace roomwise::objects
