#include "roomwise/mapping/backend/walk_joins.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

namespace roomwise::mapping {
namespace {

using geometry::RigidTransform;

// An edge between two parts of the map, each solved for itself.
struct Join {
  std::size_t edge = 0;
  KeyframeId a = 0, b = 0;  // of the earlier and the later walk
  RigidTransform a_world_from_b_world;
};

class JoinChecker {
 public:
  JoinChecker(const MapSolution& within, const WalkJoinOptions& options)
      : within_(within), options_(options) {}

  [[nodiscard]] Join join_of(const PoseGraphEdge& edge, std::size_t index) const {
    const bool goes_back = edge.from > edge.to;
    const KeyframeId a = std::min(edge.from, edge.to), b = std::max(edge.from, edge.to);
    const RigidTransform a_from_b = goes_back ? edge.from_from_to.inverse() : edge.from_from_to;
    return {index, a, b, pose(a) * a_from_b * pose(b).inverse()};
  }

  // Of joins between the same two parts, the largest number that agree with one of them; none where
  // that is too few.
  [[nodiscard]] std::vector<std::size_t> supported(const std::vector<Join>& joins) const {
    std::vector<std::size_t> best;
    for (const Join& join : joins) {
      std::vector<std::size_t> agreeing;
      std::set<KeyframeId> of_a, of_b;
      for (const Join& other : joins) {
        if (!agree(join, other)) continue;
        agreeing.push_back(other.edge);
        of_a.insert(other.a);
        of_b.insert(other.b);
      }
      const bool is_enough =
          agreeing.size() >= options_.min_agreeing && of_a.size() > 1 && of_b.size() > 1;
      if (is_enough && agreeing.size() > best.size()) best = std::move(agreeing);
    }
    return best;
  }

 private:
  [[nodiscard]] const RigidTransform& pose(KeyframeId id) const {
    return within_.world_from_keyframe[id];
  }

  [[nodiscard]] bool agree(const Join& one, const Join& other) const {
    const RigidTransform apart = one.a_world_from_b_world.inverse() * other.a_world_from_b_world;
    if (apart.angle_rad() > options_.max_angle_rad) return false;
    const double way_m = (pose(one.b).translation - pose(other.b).translation).norm();
    const double max_m = options_.max_distance_m + options_.max_drift * way_m;
    return std::ranges::all_of(std::array{one.b, other.b}, [&](KeyframeId at) {
      const Eigen::Vector3d& point = pose(at).translation;
      return (apart * point - point).norm() <= max_m;
    });
  }

  const MapSolution& within_;
  const WalkJoinOptions& options_;
};

}  // namespace

Expected<void> WalkJoinOptions::validate() const {
  if (min_agreeing < 1) return fail("min_agreeing = {} must be at least 1", min_agreeing);
  for (const auto& [name, value] :
       {std::pair("max_distance_m", max_distance_m), std::pair("max_drift", max_drift),
        std::pair("max_angle_rad", max_angle_rad)}) {
    if (!(value >= 0)) return fail("{} = {} must not be negative", name, value);
  }
  return {};
}

Expected<std::vector<PoseGraphEdge>> without_unsupported_joins(std::span<const std::size_t> part_of,
                                                               std::span<const PoseGraphEdge> edges,
                                                               const MapSolverOptions& solver,
                                                               const WalkJoinOptions& options) {
  ROOMWISE_CHECK_OK(options.validate());
  const auto is_join = [&](const PoseGraphEdge& edge) {
    return part_of[edge.from] != part_of[edge.to];
  };
  std::vector<PoseGraphEdge> within(edges.begin(), edges.end());
  if (std::ranges::none_of(edges, is_join)) return within;
  std::erase_if(within, is_join);
  ROOMWISE_TRY(const MapSolution solution, solve_map(part_of.size(), within, solver));
  const JoinChecker checker(solution, options);
  std::map<std::pair<std::size_t, std::size_t>, std::vector<Join>> joins;  // by components
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (!is_join(edges[i])) continue;
    const Join join = checker.join_of(edges[i], i);
    joins[{solution.component[join.a], solution.component[join.b]}].push_back(join);
  }
  std::set<std::size_t> supported;
  for (const auto& [components, between] : joins) {
    const std::vector<std::size_t> agreeing = checker.supported(between);
    supported.insert(agreeing.begin(), agreeing.end());
  }
  std::vector<PoseGraphEdge> kept;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (!is_join(edges[i]) || supported.contains(i)) kept.push_back(edges[i]);
  }
  return kept;
}

}  // namespace roomwise::mapping
