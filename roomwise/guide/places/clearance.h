#pragma once

#include <Eigen/Core>

#include "roomwise/fusion/floor_grid.h"

namespace roomwise::guide {

// From a place to what is occupied; infinity off the grid.
[[nodiscard]] double clearance_m(const fusion::FloorGrid& floor, const Eigen::Vector2d& place);
// Whether the whole straight line keeps that clearance.
[[nodiscard]] bool is_clear(const fusion::FloorGrid& floor, const Eigen::Vector2d& from,
                            const Eigen::Vector2d& to, double min_m);

}  // namespace roomwise::guide
