#include "roomwise/mapping/map_solver.h"

#include <algorithm>
#include <map>
#include <numeric>

namespace roomwise::mapping {
namespace {

using geometry::RigidTransform;

class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0U);
  }

  std::size_t find(std::size_t element) {
    while (parent_[element] != element) {
      parent_[element] = parent_[parent_[element]];
      element = parent_[element];
    }
    return element;
  }
  // Whether they were apart. The lower root stays, so that a set is known by its first element.
  bool join(std::size_t a, std::size_t b) {
    const auto [low, high] = std::minmax({find(a), find(b)});
    parent_[high] = low;
    return low != high;
  }

 private:
  std::vector<std::size_t> parent_;
};

// Poses along the spanning tree of the edges, in which odometry comes before loops; the first
// key-frame of each piece is at the origin.
std::vector<RigidTransform> initial_poses(std::size_t count, std::span<const PoseGraphEdge> edges) {
  struct Step {
    std::size_t to;
    RigidTransform from_from_to;
  };
  std::vector<std::vector<Step>> tree(count);
  DisjointSets joined(count);
  for (const bool loops : {false, true}) {
    for (const PoseGraphEdge& edge : edges) {
      if (edge.is_loop != loops || !joined.join(edge.from, edge.to)) continue;
      tree[edge.from].push_back({edge.to, edge.from_from_to});
      tree[edge.to].push_back({edge.from, edge.from_from_to.inverse()});
    }
  }
  std::vector<RigidTransform> poses(count);
  std::vector<bool> placed(count, false);
  for (std::size_t root = 0; root < count; ++root) {
    if (placed[root]) continue;
    placed[root] = true;
    std::vector<std::size_t> open{root};
    while (!open.empty()) {
      const std::size_t from = open.back();
      open.pop_back();
      for (const Step& step : tree[from]) {
        if (placed[step.to]) continue;
        placed[step.to] = true;
        poses[step.to] = poses[from] * step.from_from_to;
        open.push_back(step.to);
      }
    }
  }
  return poses;
}

// The piece of each key-frame, the largest first; among equals the earlier.
std::vector<std::size_t> pieces_by_size(std::size_t count, std::span<const PoseGraphEdge> edges,
                                        std::size_t& pieces) {
  DisjointSets joined(count);
  for (const PoseGraphEdge& edge : edges) joined.join(edge.from, edge.to);
  std::vector<std::size_t> size(count, 0);
  std::vector<std::size_t> roots;
  for (std::size_t id = 0; id < count; ++id) {
    if (joined.find(id) == id) roots.push_back(id);
    ++size[joined.find(id)];
  }
  std::ranges::stable_sort(roots, [&](std::size_t a, std::size_t b) { return size[a] > size[b]; });
  std::vector<std::size_t> rank(count, 0);
  for (std::size_t i = 0; i < roots.size(); ++i) rank[roots[i]] = i;
  std::vector<std::size_t> piece(count);
  for (std::size_t id = 0; id < count; ++id) piece[id] = rank[joined.find(id)];
  pieces = roots.size();
  return piece;
}

double edge_error(const PoseGraph& graph, const PoseGraphEdge& edge) {
  return pose_graph_error({{{edge.from, graph.world_from_node.at(edge.from)},
                            {edge.to, graph.world_from_node.at(edge.to)}},
                           {edge}});
}

}  // namespace

Expected<void> MapSolverOptions::validate() const {
  ROOMWISE_CHECK_OK(graph.validate());
  if (!(most_loop_error > 0)) return fail("most_loop_error = {} must be positive", most_loop_error);
  return {};
}

bool is_contradicted(const PoseGraph& graph, const PoseGraphEdge& edge,
                     const MapSolverOptions& options) {
  return edge.is_loop && edge_error(graph, edge) > options.most_loop_error;
}

Expected<MapSolution> solve_map(std::size_t keyframe_count, std::span<const PoseGraphEdge> edges,
                                const MapSolverOptions& options) {
  ROOMWISE_CHECK_OK(options.validate());
  MapSolution solution;
  if (keyframe_count == 0) return solution;
  for (const PoseGraphEdge& edge : edges) {
    if (std::max(edge.from, edge.to) >= keyframe_count) {
      return fail("an edge from key-frame {} to {} in a map of {} key-frames", edge.from, edge.to,
                  keyframe_count);
    }
  }
  PoseGraph graph;
  graph.edges.assign(edges.begin(), edges.end());
  const std::vector<RigidTransform> start = initial_poses(keyframe_count, edges);
  for (std::size_t id = 0; id < keyframe_count; ++id) graph.world_from_node[id] = start[id];

  // First robustly, to see which loops contradict the rest; then without those, as least squares.
  PoseGraphOptions robust = options.graph;
  robust.loop_kernel = options.most_loop_error / 4;
  ROOMWISE_TRY(const PoseGraphReport first, optimize(graph, robust));
  solution.rejected_loops = std::erase_if(graph.edges, [&](const PoseGraphEdge& edge) {
    return is_contradicted(graph, edge, options);
  });
  solution.piece = pieces_by_size(keyframe_count, graph.edges, solution.pieces);
  ROOMWISE_TRY(solution.report, optimize(graph, options.graph));
  solution.report.error_before = first.error_before;
  solution.report.iterations += first.iterations;

  // The world of each piece is its first key-frame, also where leaving out a loop split it off.
  std::map<std::size_t, RigidTransform> first_from_world;
  for (const auto& [id, pose] : graph.world_from_node) {
    const auto [anchor, is_first] =
        first_from_world.try_emplace(solution.piece[id], pose.inverse());
    solution.world_from_keyframe.push_back(is_first ? RigidTransform::identity()
                                                    : anchor->second * pose);
  }
  return solution;
}

}  // namespace roomwise::mapping
