#include "roomwise/mapping/backend/walk_joins.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "roomwise/base/spread.h"

namespace roomwise::mapping {
namespace {

using geometry::RigidTransform;

// An edge between two parts of the map, each solved for itself.
struct Join {
  std::size_t edge = 0;
  KeyframeId a = 0, b = 0;  // of the part with the lower number, and of the other
  RigidTransform a_world_from_b_world;
};

class JoinChecker {
 public:
  JoinChecker(const MapSolution& within, const WalkJoinOptions& options)
      : within_(within), options_(options) {}

  [[nodiscard]] Join join_of(const PoseGraphEdge& edge, std::size_t index) const {
    KeyframeId a = edge.from, b = edge.to;
    RigidTransform a_from_b = edge.from_from_to;
    if (std::pair(within_.component[a], a) > std::pair(within_.component[b], b)) {
      std::swap(a, b);
      a_from_b = a_from_b.inverse();
    }
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
          agreeing.size() >= options_.min_agreeing_edges && of_a.size() > 1 && of_b.size() > 1;
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

// Key-frames of one part that may show what another shows, and what comparing them tells.
class ViewJudge {
 public:
  ViewJudge(const MapSolution& solution, const CompareDepths& compare,
            const WalkJoinOptions& options)
      : poses_(solution.world_from_keyframe), compare_(compare), options_(options) {}

  // Where their views say that two parts are different places, the share of what overlaps that is
  // the same surface all the same.
  [[nodiscard]] std::optional<double> contradiction(std::span<const KeyframeId> one,
                                                    std::span<const KeyframeId> other) const {
    if (other.size() < one.size()) std::swap(one, other);
    Shared shared;
    for (const auto& [id, nearest] : compared(one, other)) {
      for (const KeyframeId near : nearest) {
        // Both ways round: what hides something looks the other way like what is seen through.
        shared.add(agreement(id, near));
        shared.add(agreement(near, id));
      }
    }
    const bool is_contradicted = shared.overlap > 0 && shared.most >= options_.min_overlap &&
                                 (shared.agreeing < options_.min_agreeing * shared.overlap ||
                                  shared.seen_through > options_.max_seen_through * shared.overlap);
    if (!is_contradicted) return std::nullopt;
    return shared.agreeing / shared.overlap;
  }

 private:
  // Sums over pairs of views, each by its overlap.
  struct Shared {
    double most = 0, overlap = 0, agreeing = 0, seen_through = 0;

    void add(const motion::ViewAgreement& pair) {
      most = std::max(most, pair.overlap);
      overlap += pair.overlap;
      agreeing += pair.overlap * pair.agreeing;
      seen_through += pair.overlap * pair.seen_through;
    }
  };

  [[nodiscard]] motion::ViewAgreement agreement(KeyframeId reference, KeyframeId current) const {
    return compare_(reference, current, poses_[reference].inverse() * poses_[current]);
  }

  // Those of `other` that may show the same as the key-frame, the nearest first; a metre counts as
  // a radian.
  [[nodiscard]] std::vector<KeyframeId> nearest(KeyframeId id,
                                                std::span<const KeyframeId> other) const {
    std::vector<std::pair<double, KeyframeId>> near;
    const RigidTransform from_world = poses_[id].inverse();
    for (const KeyframeId at : other) {
      const RigidTransform apart = from_world * poses_[at];
      if (apart.distance_m() > options_.place_m || apart.angle_rad() > options_.place_rad) continue;
      near.emplace_back(apart.distance_m() + apart.angle_rad(), at);
    }
    std::ranges::sort(near);
    near.resize(std::min(near.size(), options_.max_nearest));
    std::vector<KeyframeId> ids;
    for (const auto& [distance, at] : near) ids.push_back(at);
    return ids;
  }

  // Spread evenly over those that have something near.
  [[nodiscard]] std::vector<std::pair<KeyframeId, std::vector<KeyframeId>>> compared(
      std::span<const KeyframeId> one, std::span<const KeyframeId> other) const {
    std::vector<std::pair<KeyframeId, std::vector<KeyframeId>>> all;
    for (const KeyframeId id : one) {
      if (auto near = nearest(id, other); !near.empty()) all.emplace_back(id, std::move(near));
    }
    return spread_evenly(all, options_.max_compared);
  }

  const std::vector<RigidTransform>& poses_;
  const CompareDepths& compare_;
  const WalkJoinOptions& options_;
};

}  // namespace

Expected<void> WalkJoinOptions::validate() const {
  for (const auto& [name, value] :
       {std::pair("min_agreeing_edges", min_agreeing_edges),
        std::pair("max_compared", max_compared), std::pair("max_nearest", max_nearest)}) {
    if (value < 1) return fail("{} = {} must be at least 1", name, value);
  }
  for (const auto& [name, value] :
       {std::pair("max_distance_m", max_distance_m), std::pair("max_drift", max_drift),
        std::pair("max_angle_rad", max_angle_rad), std::pair("place_m", place_m),
        std::pair("place_rad", place_rad), std::pair("min_overlap", min_overlap),
        std::pair("min_agreeing", min_agreeing), std::pair("max_seen_through", max_seen_through)}) {
    if (!(value >= 0)) return fail("{} = {} must not be negative", name, value);
  }
  return {};
}

Expected<std::vector<PoseGraphEdge>> without_unsupported_joins(std::span<const std::size_t> part_of,
                                                               std::span<const PoseGraphEdge> edges,
                                                               const MapSolverOptions& solver,
                                                               const WalkJoinOptions& options) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
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

Expected<std::vector<PoseGraphEdge>> without_contradicted_joins(
    std::span<const std::size_t> part_of, std::span<const PoseGraphEdge> edges,
    const MapSolution& solution, const CompareDepths& compare, const WalkJoinOptions& options) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  const auto is_join = [&](const PoseGraphEdge& edge) {
    return part_of[edge.from] != part_of[edge.to];
  };
  std::vector<PoseGraphEdge> kept(edges.begin(), edges.end());
  if (std::ranges::none_of(edges, is_join)) return kept;
  // A part may hang together by nothing of its own: each piece of it is judged for itself.
  std::vector<PoseGraphEdge> within = kept;
  std::erase_if(within, is_join);
  std::size_t count = 0;
  const std::vector<std::size_t> piece_of = components_by_size(part_of.size(), within, count);
  std::vector<std::vector<KeyframeId>> pieces(count);
  for (KeyframeId id = 0; id < piece_of.size(); ++id) pieces[piece_of[id]].push_back(id);
  const auto joined_by = [&](const PoseGraphEdge& edge) -> std::pair<std::size_t, std::size_t> {
    return std::minmax({piece_of[edge.from], piece_of[edge.to]});
  };
  std::set<std::pair<std::size_t, std::size_t>> joined;
  for (const PoseGraphEdge& edge : edges) {
    if (is_join(edge)) joined.insert(joined_by(edge));
  }
  const ViewJudge judge(solution, compare, options);
  std::optional<std::pair<double, std::pair<std::size_t, std::size_t>>> worst;
  for (const auto& [one, other] : joined) {
    const std::optional<double> agreeing = judge.contradiction(pieces[one], pieces[other]);
    if (agreeing && (!worst || *agreeing < worst->first)) worst = {*agreeing, {one, other}};
  }
  std::erase_if(kept, [&](const PoseGraphEdge& edge) {
    return worst && is_join(edge) && joined_by(edge) == worst->second;
  });
  return kept;
}

}  // namespace roomwise::mapping
