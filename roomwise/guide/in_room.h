#pragma once

#include <Eigen/Core>
#include <string>

#include "roomwise/guide/plan.h"

namespace roomwise::guide {

// Whether somebody who stands there is in the room with their whole body: a layout tells rooms
// apart to a foot's length, and who stands in a door's frame is in neither.
[[nodiscard]] bool is_well_inside(const HomeMap& map, const std::string& room,
                                  const Eigen::Vector2d& place_gravity);

}  // namespace roomwise::guide
