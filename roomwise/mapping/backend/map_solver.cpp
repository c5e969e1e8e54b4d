#include "roomwise/mapping/backend/map_solver.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>

#include "roomwise/base/disjoint_sets.h"

namespace roomwise::mapping {
namespace {

using geometry::RigidTransform;

// How unsure an edge claims to be.
struct Spread {
  double translation_m = 0;
  double rotation_rad = 0;
};

Spread spread_of(const PoseGraphEdge& edge) {
  // What the edge does not determine at all counts as very unsure.
  constexpr double kMinInformation = 1e-6;
  const geometry::Matrix6d covariance =
      (edge.information + kMinInformation * geometry::Matrix6d::Identity()).inverse();
  return {std::sqrt(covariance.topLeftCorner<3, 3>().trace()),
          2 * std::sqrt(covariance.bottomRightCorner<3, 3>().trace())};
}

struct Step {
  std::size_t to;
  RigidTransform from_from_to;
  Spread spread = {};
};
using StepsFrom = std::vector<std::vector<Step>>;  // by key-frame id

void add_both_ways(StepsFrom& steps, const PoseGraphEdge& edge) {
  const Spread spread = spread_of(edge);
  steps[edge.from].push_back({edge.to, edge.from_from_to, spread});
  steps[edge.to].push_back({edge.from, edge.from_from_to.inverse(), spread});
}

// What the triangles of edges say of each edge: those in which going round leads back count for it,
// the others against.
std::vector<int> triangle_votes(std::size_t count, std::span<const PoseGraphEdge> edges) {
  // Give or take what the edges themselves claim to be unsure of.
  constexpr double kClosed_m = 0.05;
  constexpr double kClosed_rad = 0.03;
  constexpr double kSigmas = 2;
  StepsFrom steps(count);
  // The device's motion is asked only where pictures say nothing: it has no vote on what they say.
  for (const PoseGraphEdge& edge : edges) {
    if (!edge.is_device_motion) add_both_ways(steps, edge);
  }
  for (std::vector<Step>& from : steps) std::ranges::stable_sort(from, {}, &Step::to);
  std::vector<int> votes;
  for (const PoseGraphEdge& edge : edges) {
    int& vote = votes.emplace_back(0);
    if (edge.is_device_motion) continue;
    const Spread own = spread_of(edge);
    // Both lists are sorted: a walk along them finds the common neighbours.
    auto b = steps[edge.to].begin();
    for (const Step& a : steps[edge.from]) {
      while (b != steps[edge.to].end() && b->to < a.to) ++b;
      if (b == steps[edge.to].end()) break;
      if (b->to != a.to || a.to == edge.from || a.to == edge.to) continue;
      const RigidTransform around =
          a.from_from_to * b->from_from_to.inverse() * edge.from_from_to.inverse();
      const double unsure_m =
          std::hypot(own.translation_m, a.spread.translation_m, b->spread.translation_m);
      const double unsure_rad =
          std::hypot(own.rotation_rad, a.spread.rotation_rad, b->spread.rotation_rad);
      vote += around.distance_m() < kClosed_m + kSigmas * unsure_m &&
                      around.angle_rad() < kClosed_rad + kSigmas * unsure_rad
                  ? 1
                  : -1;
    }
  }
  return votes;
}

// Poses along a spanning tree of the edges: first those for which triangles vote, then those that
// are in none, last those that others contradict, and in each odometry before loops. The first
// key-frame of each component is at the origin.
std::vector<RigidTransform> initial_poses(std::size_t count, std::span<const PoseGraphEdge> edges,
                                          const std::vector<int>& votes) {
  StepsFrom tree(count);
  DisjointSets joined(count);
  for (const int sign : {1, 0, -1}) {
    for (const bool loops : {false, true}) {
      for (std::size_t i = 0; i < edges.size(); ++i) {
        const PoseGraphEdge& edge = edges[i];
        if (edge.is_robust != loops || (votes[i] > 0) - (votes[i] < 0) != sign) continue;
        if (joined.join(edge.from, edge.to)) add_both_ways(tree, edge);
      }
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

// A step that most triangles contradict is no surer than a loop.
std::vector<PoseGraphEdge> demote_inconsistent_odometry(std::span<const PoseGraphEdge> edges,
                                                        const std::vector<int>& votes) {
  std::vector<PoseGraphEdge> doubted(edges.begin(), edges.end());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (votes[i] < 0) doubted[i].is_robust = true;
  }
  return doubted;
}

double loop_error(const PoseGraph& graph, const PoseGraphEdge& edge) {
  return pose_graph_chi2({{{edge.from, graph.world_from_node.at(edge.from)},
                           {edge.to, graph.world_from_node.at(edge.to)}},
                          {edge}});
}

}  // namespace

Expected<void> MapSolverOptions::validate() const {
  ROOMWISE_RETURN_IF_ERROR(graph.validate());
  if (!(max_loop_error > 0)) return fail("max_loop_error = {} must be positive", max_loop_error);
  return {};
}

std::vector<std::size_t> components_by_size(std::size_t count, std::span<const PoseGraphEdge> edges,
                                            std::size_t& components) {
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
  std::vector<std::size_t> component(count);
  for (std::size_t id = 0; id < count; ++id) component[id] = rank[joined.find(id)];
  components = roots.size();
  return component;
}

bool is_contradicted(const PoseGraph& graph, const PoseGraphEdge& edge,
                     const MapSolverOptions& options) {
  return edge.is_robust && loop_error(graph, edge) > options.max_loop_error;
}

std::vector<PoseGraphEdge> demote_inconsistent_odometry(std::size_t keyframe_count,
                                                        std::span<const PoseGraphEdge> edges) {
  return demote_inconsistent_odometry(edges, triangle_votes(keyframe_count, edges));
}

Expected<MapSolution> solve_map(std::size_t keyframe_count, std::span<const PoseGraphEdge> edges,
                                const MapSolverOptions& options) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  MapSolution solution;
  if (keyframe_count == 0) return solution;
  for (const PoseGraphEdge& edge : edges) {
    if (std::max(edge.from, edge.to) >= keyframe_count) {
      return fail("an edge from key-frame {} to {} in a map of {} key-frames", edge.from, edge.to,
                  keyframe_count);
    }
  }
  const std::vector<int> votes = triangle_votes(keyframe_count, edges);
  PoseGraph graph;
  graph.edges = demote_inconsistent_odometry(edges, votes);
  const std::vector<RigidTransform> start = initial_poses(keyframe_count, edges, votes);
  for (std::size_t id = 0; id < keyframe_count; ++id) graph.world_from_node[id] = start[id];

  // First robustly, to see which loops contradict the rest; then without those, as least squares.
  // The spanning tree trusts what triangles bear out; a relaxation would trust wrong loops as well.
  PoseGraphOptions plain = options.graph;
  plain.relaxes_start = false;
  PoseGraphOptions robust = plain;
  robust.loop_kernel = options.max_loop_error / 4;
  ROOMWISE_TRY(const PoseGraphReport first, optimize(graph, robust));
  solution.rejected_edges = std::erase_if(graph.edges, [&](const PoseGraphEdge& edge) {
    return is_contradicted(graph, edge, options);
  });
  solution.component = components_by_size(keyframe_count, graph.edges, solution.components);
  ROOMWISE_TRY(solution.report, optimize(graph, plain));
  solution.report.error_before = first.error_before;
  solution.report.iterations += first.iterations;

  // The world of each component is its first key-frame, also where leaving out a loop split it off.
  std::map<std::size_t, RigidTransform> first_from_world;
  for (const auto& [id, pose] : graph.world_from_node) {
    const auto [anchor, is_first] =
        first_from_world.try_emplace(solution.component[id], pose.inverse());
    solution.world_from_keyframe.push_back(is_first ? RigidTransform::identity()
                                                    : anchor->second * pose);
  }
  return solution;
}

}  // namespace roomwise::mapping
