#pragma once

#include <cstdint>
#include <vector>

#include "roomwise/geometry/levenberg_marquardt.h"
#include "roomwise/mapping/graph/pose_graph.h"

namespace roomwise::mapping {

// A pose graph as its solver wants it: numbered poses, of which the first so many stay where they
// are, and edges that were checked.
struct NumberedEdge {
  std::uint32_t from = 0;
  std::uint32_t to = 0;
  const PoseGraphEdge* edge = nullptr;
  double kernel = 0;  // e^T Omega e above which the edge counts less and less; 0: no kernel
};
struct IndexedGraph {
  std::vector<geometry::RigidTransform> world_from_node;
  std::size_t fixed_pose_count = 0;
  std::vector<NumberedEdge> edges;
};

// Moves the poses that may move to a minimum of the sum of the edges' costs.
[[nodiscard]] geometry::MinimizerSummary minimize(IndexedGraph& graph,
                                                  const PoseGraphOptions& options,
                                                  const Interruption& interruption = {});

}  // namespace roomwise::mapping
