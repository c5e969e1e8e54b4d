#pragma once

#include <Eigen/Core>
#include <span>

namespace roomwise::geometry {

// How a home is turned where it is drawn from above: the direction that lies to the right, in
// radians counter-clockwise from x. Most walls run along or across it, to a degree; the longer side
// lies across; `begin`, where the walk began, lies in the left half. `points`: of walls and what
// else stands there, m, seen from above; without any 0. `cell_m`: not 0 where they are middles of a
// grid's cells, whose rows would pass for walls: each is then taken somewhere in its cell.
[[nodiscard]] double drawing_direction_rad(std::span<const Eigen::Vector2d> points,
                                           const Eigen::Vector2d& begin, double cell_m = 0);

}  // namespace roomwise::geometry
