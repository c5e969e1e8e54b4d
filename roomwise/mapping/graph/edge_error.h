#pragma once

#include "roomwise/mapping/graph/pose_graph.h"

namespace roomwise::mapping {

// How an edge's error changes with the poses at its ends: de = by_from * step of the pose `from` +
// by_to * step of `to`, where a step (in the order x, y, z, then a rotation vector) moves the
// translation along the world's axes and turns the node about its own: see retract().
struct EdgeJacobians {
  geometry::Matrix6d by_from;
  geometry::Matrix6d by_to;
};

// The error e of PoseGraphEdge at poses world_from_from and world_from_to.
[[nodiscard]] geometry::Vector6d edge_error(const geometry::RigidTransform& from_from_to,
                                            const geometry::RigidTransform& world_from_from,
                                            const geometry::RigidTransform& world_from_to);

[[nodiscard]] EdgeJacobians edge_jacobians(const geometry::RigidTransform& from_from_to,
                                           const geometry::RigidTransform& world_from_from,
                                           const geometry::RigidTransform& world_from_to);

// The pose after a step.
[[nodiscard]] geometry::RigidTransform retract(const geometry::RigidTransform& world_from_node,
                                               const geometry::Vector6d& step);

}  // namespace roomwise::mapping
