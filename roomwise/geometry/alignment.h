#pragma once

#include <Eigen/Core>
#include <span>

#include "roomwise/base/expected.h"
#include "roomwise/geometry/rigid_transform.h"

namespace roomwise::geometry {

// The rigid transform to_from_from that minimises the sum of squared distances between to[i] and
// to_from_from * from[i] (Horn 1987, by the singular value decomposition of Arun et al. and
// Umeyama). Fails for fewer than three pairs, or points on one line, where the rotation is not
// determined.
[[nodiscard]] Expected<RigidTransform> align_points(std::span<const Eigen::Vector3d> from,
                                                    std::span<const Eigen::Vector3d> to);

}  // namespace roomwise::geometry
