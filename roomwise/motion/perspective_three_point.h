#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "roomwise/geometry/rigid_transform.h"

namespace roomwise::motion {

// The camera poses from which three points are seen along three rays: up to four solutions
// camera_from_points, none for points on one line. `points` are in any frame, m; `rays` are unit
// vectors of the camera frame. Grunert's solution as reviewed by Haralick et al., "Review and
// analysis of solutions of the three point perspective pose estimation problem", IJCV 1994.
[[nodiscard]] std::vector<geometry::RigidTransform> solve_p3p(
    const std::array<Eigen::Vector3d, 3>& points, const std::array<Eigen::Vector3d, 3>& rays);

}  // namespace roomwise::motion
