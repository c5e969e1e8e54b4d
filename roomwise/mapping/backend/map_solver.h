#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "roomwise/mapping/frontend/keyframe.h"
#include "roomwise/mapping/frontend/mapper.h"
#include "roomwise/mapping/graph/pose_graph.h"

namespace roomwise::mapping {

struct MapSolverOptions {
  PoseGraphOptions graph;
  // A wrong loop must not distort the map: a loop whose e^T Omega e exceeds this after a robust
  // optimisation is left out of the final one.
  double max_loop_error = 200.0;

  [[nodiscard]] Expected<void> validate() const;
};

// Where the key-frames are, once all measurements agree as well as they can.
struct MapSolution {
  // By key-frame id. Each component lies in a world of its own, its first key-frame's camera
  // frame.
  std::vector<geometry::RigidTransform> world_from_keyframe;
  // By key-frame id: its component, 0 for the largest (by key-frames), then by size.
  std::vector<std::size_t> component;
  std::size_t components = 0;
  std::size_t rejected_edges = 0;  // and steps, where triangles made them doubtful
  PoseGraphReport report;
};

// The connected component of each key-frame, the largest (by key-frames) first, among equals the
// earlier; their number goes to `components`.
[[nodiscard]] std::vector<std::size_t> components_by_size(std::size_t keyframe_count,
                                                          std::span<const PoseGraphEdge> edges,
                                                          std::size_t& components);

// The edges as solve_map() takes them: a step that most triangles of edges contradict is no surer
// than a loop, and becomes one. All edges must be between key-frames below the count.
[[nodiscard]] std::vector<PoseGraphEdge> demote_inconsistent_odometry(
    std::size_t keyframe_count, std::span<const PoseGraphEdge> edges);

// Whether a loop's error (after demote_inconsistent_odometry()) at these poses is more than a map
// accepts: solve_map() left it out, or would.
[[nodiscard]] bool is_contradicted(const PoseGraph& graph, const PoseGraphEdge& edge,
                                   const MapSolverOptions& options = {});

// The pose graph of a map: starts from the spanning tree of odometry, then loops, and minimises
// F(x) = sum of e^T Omega e (section "pose graph" of the paper, as in g2o).
[[nodiscard]] Expected<MapSolution> solve_map(std::size_t keyframe_count,
                                              std::span<const PoseGraphEdge> edges,
                                              const MapSolverOptions& options = {});

}  // namespace roomwise::mapping
