#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/base/progress.h"
#include "roomwise/geometry/levenberg_marquardt.h"
#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/scene/pose_graph_edge.h"

namespace roomwise::mapping {

using NodeId = std::uint64_t;

using scene::PoseGraphEdge;

struct PoseGraph {
  std::map<NodeId, geometry::RigidTransform> world_from_node;
  std::vector<PoseGraphEdge> edges;
};

// F(x): the sum of e^T Omega e over all edges, without robust kernels. Every edge's nodes must be
// there.
[[nodiscard]] double pose_graph_chi2(const PoseGraph& graph);

struct PoseGraphOptions {
  int max_iterations = 100;
  // Stops when an iteration lowers F by less than this part of it, or when the gradient promises no
  // more than that.
  double relative_tolerance = 1e-9;
  // e^T Omega e of a loop closure above which it counts less and less (Cauchy's kernel); 0: no
  // kernel.
  double loop_kernel = 0;
  // Begins from a chordal relaxation (chordal_start.h) where the edges' costs are lower there than
  // at the poses given: these may be far from all minima, as where noisy steps were added up.
  bool relaxes_start = true;

  [[nodiscard]] Expected<void> validate() const;
};

struct PoseGraphReport {
  double error_before = 0;  // F at the poses given
  double error_after = 0;   // F at the end
  int iterations = 0;
  geometry::Termination termination = geometry::Termination::kConverged;
  // Edges whose information is not positive semi-definite, as some published graphs have them: in
  // the directions in which it is negative they were taken to say nothing.
  std::size_t indefinite_edges = 0;
};

// Moves the poses to a minimum of F (Levenberg and Marquardt's method, sparse Cholesky
// factorisation: see pose_graph_solver.h and block_cholesky.h) with the lowest-numbered node of
// each connected part held still. Runs on one thread and calls no BLAS, so that the same graph
// gives the same bits. Fails, naming node or edge and leaving the graph as it was, on an edge to a
// node that is not there or to itself, poses or information that are not finite, quaternions not of
// unit length, information that is not symmetric, and when it is interrupted, which it asks for
// before each step of the relaxation and each iteration. Where `max_iterations` did not suffice,
// the poses are the best so far and the report says so.
[[nodiscard]] Expected<PoseGraphReport> optimize(PoseGraph& graph,
                                                 const PoseGraphOptions& options = {},
                                                 const Interruption& interruption = {});

}  // namespace roomwise::mapping
