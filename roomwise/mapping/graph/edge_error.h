#pragma once

#include "roomwise/mapping/graph/pose_graph.h"

namespace roomwise::mapping {

// How an edge's error changes with the poses at its ends: de = d_from * step of the pose `from` +
// d_to * step of `to`, where a step (in the order x, y, z, then a rotation vector) moves the
// translation along the world's axes and turns the node about its own: see retract().
struct EdgeJacobians {
  geometry::Matrix6d d_from;
  geometry::Matrix6d d_to;
};

// The error e of PoseGraphEdge at poses world_from_from and world_from_to.
[[nodiscard]] geometry::Vector6d edge_error(const geometry::RigidTransform& from_from_to,
                                            const geometry::RigidTransform& world_from_from,
                                            const geometry::RigidTransform& world_from_to);

[[nodiscard]] EdgeJacobians edge_jacobians(const geometry::RigidTransform& from_from_to,
                                           const geometry::RigidTransform& world_from_from,
                                           const geometry::RigidTransform& world_from_to);

// e^T Omega e of an edge, with Cauchy's kernel above this size of it (0: no kernel).
[[nodiscard]] double edge_cost(const PoseGraphEdge& edge,
                               const geometry::RigidTransform& world_from_from,
                               const geometry::RigidTransform& world_from_to, double kernel = 0);

// An edge's part of the normal equations of both poses' steps.
struct EdgeEquations {
  geometry::Matrix6d from_hessian, to_hessian, from_to_hessian;
  geometry::Vector6d from_rhs, to_rhs;  // half the gradient, downhill
};
[[nodiscard]] EdgeEquations linearize(const PoseGraphEdge& edge,
                                      const geometry::RigidTransform& world_from_from,
                                      const geometry::RigidTransform& world_from_to,
                                      double kernel = 0);

// The pose after a step.
[[nodiscard]] geometry::RigidTransform retract(const geometry::RigidTransform& world_from_node,
                                               const geometry::Vector6d& step);

}  // namespace roomwise::mapping
