#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/geometry/rigid_transform.h"

namespace roomwise::mapping {

using NodeId = std::uint64_t;

// A measurement of one pose relative to another. The error that the optimisation squares is g2o's
// for EDGE_SE3:QUAT: with d = from_from_to^-1 * world_from_from^-1 * world_from_to,
//   e = (translation of d in m, vector part of d's unit quaternion, taken with w >= 0).
struct PoseGraphEdge {
  NodeId from = 0;
  NodeId to = 0;
  geometry::RigidTransform from_from_to;
  // Omega: inverse covariance of e, in the order (x, y, z, qx, qy, qz). Symmetric, positive
  // semi-definite.
  geometry::Matrix6d information = geometry::Matrix6d::Identity();
  // A loop closure may be wrong and gets a robust kernel; a step of the odometry does not.
  bool is_loop = false;
};

struct PoseGraph {
  std::map<NodeId, geometry::RigidTransform> world_from_node;
  std::vector<PoseGraphEdge> edges;
};

// F(x): the sum of e^T Omega e over all edges, without robust kernels. Every edge's nodes must be
// there.
[[nodiscard]] double pose_graph_error(const PoseGraph& graph);

struct PoseGraphOptions {
  int max_iterations = 100;
  // Stops when an iteration lowers F by less than this part of it, or when the gradient promises no
  // more than that.
  double relative_tolerance = 1e-9;
  // e^T Omega e of a loop closure above which it counts less and less (Cauchy's kernel); 0: no
  // kernel.
  double loop_kernel = 0;

  [[nodiscard]] Expected<void> validate() const;
};

struct PoseGraphReport {
  double error_before = 0;  // F at the start
  double error_after = 0;   // F at the end
  int iterations = 0;
  bool converged = false;
};

// Moves the poses to a minimum of F (Levenberg and Marquardt's method, sparse Cholesky
// factorisation: see pose_graph_solver.h and block_cholesky.h) with the lowest-numbered node of
// each connected part held still. Runs on one thread and calls no BLAS, so that the same graph
// gives the same bits. Fails, naming node or edge and leaving the graph as it was, on an edge to a
// node that is not there or to itself, poses or information that are not finite, quaternions not of
// unit length, information that is not symmetric positive semi-definite. Where `max_iterations`
// did not suffice, the poses are the best so far and the report says so.
[[nodiscard]] Expected<PoseGraphReport> optimize(PoseGraph& graph,
                                                 const PoseGraphOptions& options = {});

}  // namespace roomwise::mapping
