#include "roomwise/objects/changes/changes.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <tuple>

#include "roomwise/objects/changes/point_votes.h"
#include "roomwise/objects/instances/world_observation.h"
#include "roomwise/objects/kinds/kinds.h"

namespace roomwise::objects {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kBoxSlack_m = 0.05;

// The share of a thing's surface in the other's box, of the two the larger.
double shared_place(const PlacedInstance& a, const PlacedInstance& b) {
  const auto inside = [](const PlacedInstance& one, const geometry::OrientedBox& box) {
    if (one.surface_world.empty()) return 0.0;
    const auto count = std::ranges::count_if(one.surface_world, [&](const Vector3f& point) {
      return box.distance_m(point.cast<double>()) <= kBoxSlack_m;
    });
    return static_cast<double>(count) / static_cast<double>(one.surface_world.size());
  };
  return std::max(inside(a, b.box_world), inside(b, a.box_world));
}

double distance_m(const PlacedInstance& a, const PlacedInstance& b) {
  return (a.box_world.center() - b.box_world.center()).norm();
}

struct Pair {
  double cost = 0;
  std::size_t a = 0, b = 0;
};
// Takes pairs, the cheapest first, each of both used once.
void take_pairs(std::vector<Pair> pairs, std::size_t count_a, std::size_t count_b,
                const std::function<void(const Pair&)>& take) {
  std::ranges::sort(pairs, {}, [](const Pair& p) { return std::tuple(p.cost, p.a, p.b); });
  std::vector<bool> used_a(count_a), used_b(count_b);
  for (const Pair& pair : pairs) {
    if (used_a[pair.a] || used_b[pair.b]) continue;
    used_a[pair.a] = used_b[pair.b] = true;
    take(pair);
  }
}

// Whether they may be one thing whose place is in doubt: their middles lie closer than half of the
// mean diagonal of their footprints.
bool stand_in_one_place(const PlacedInstance& a, const PlacedInstance& b) {
  const double half_m =
      0.25 * (a.box_world.size_m.head<2>().norm() + b.box_world.size_m.head<2>().norm());
  return distance_m(a, b) <= std::max(kBoxSlack_m, half_m);
}

class ChangeFinder {
 public:
  ChangeFinder(std::span<const PlacedInstance> before, std::span<const PlacedInstance> now,
               const ChangeOptions& options)
      : before_(before), now_(now), options_(options), taken_(now.size()) {
    changes_.before.resize(before.size());
  }

  Changes find(std::span<const DepthView> views_before, std::span<const DepthView> views_now,
               std::span<const PlacedInstance> past) {
    for (std::size_t i = 0; i < before_.size(); ++i) {
      changes_.before[i].evidence = surface_evidence(before_[i].surface_world, views_now);
    }
    for (const PlacedInstance& thing : now_) {
      evidence_before_.push_back(surface_evidence(thing.surface_world, views_before));
    }
    was_there_in_past_.resize(now_.size());
    for (const auto& match : match_by_name_and_place(past, now_)) {
      if (match) was_there_in_past_[*match] = true;
    }
    find_in_place();
    judge_others();
    collect_arrivals();
    join_moved();
    return std::move(changes_);
  }

 private:
  [[nodiscard]] bool is_observed(const FreeSpaceEvidence& evidence) const {
    return evidence.decided_share() >= options_.min_decided && evidence.views >= options_.min_views;
  }
  [[nodiscard]] bool differs(const FreeSpaceEvidence& evidence, double least) const {
    const double gone =
        options_.of_whole_surface ? evidence.gone_share_of_whole() : evidence.gone_share();
    return is_observed(evidence) && gone >= least;
  }
  [[nodiscard]] bool is_new(std::size_t now, double least) const {
    return was_there_in_past_[now] || differs(evidence_before_[now], least);
  }

  // Rule 1: what is found where it was is there, or has moved a little.
  void find_in_place() {
    std::vector<Pair> pairs;
    for (std::size_t b = 0; b < before_.size(); ++b) {
      for (std::size_t n = 0; n < now_.size(); ++n) {
        if (before_[b].name != now_[n].name) continue;
        const double shared = shared_place(before_[b], now_[n]);
        if (shared >= options_.same_place) pairs.push_back({-shared, b, n});
      }
    }
    take_pairs(std::move(pairs), before_.size(), now_.size(), [&](const Pair& pair) {
      InstanceChange& state = changes_.before[pair.a];
      state.now = pair.b;
      state.evidence_now = evidence_before_[pair.b];
      taken_[pair.b] = true;
      const bool shifted =
          differs(state.evidence, options_.min_moved_gone_share) &&
          is_new(pair.b, options_.min_moved_gone_share) &&
          distance_m(before_[pair.a], now_[pair.b]) >= options_.min_moved_distance_m;
      state.state = shifted ? ChangeState::kMoved : ChangeState::kThere;
    });
  }

  // Rule 2: of the rest, depth tells what is gone.
  void judge_others() {
    for (InstanceChange& state : changes_.before) {
      if (state.now) continue;
      if (!is_observed(state.evidence)) continue;
      const PlacedInstance& thing =
          before_[static_cast<std::size_t>(&state - changes_.before.data())];
      state.state =
          differs(state.evidence, options_.min_gone) ? ChangeState::kRemoved
          : !is_fixed(thing.name) && differs(state.evidence, options_.min_shifted_gone_share)
              ? ChangeState::kShifted
              : ChangeState::kThere;
    }
  }
  // Nobody pushes a sink.
  static bool is_fixed(const std::string& name) {
    const Kind* const kind = find_kind(name);
    return kind != nullptr && kind->is_fixed;
  }

  // Rule 3: what depth did not show before has arrived. Where a thing is still that had another
  // name, nothing is new.
  void collect_arrivals() {
    for (std::size_t n = 0; n < now_.size(); ++n) {
      if (taken_[n] || !is_new(n, options_.min_gone)) continue;
      bool is_there = false;
      for (std::size_t b = 0; b < before_.size() && !is_there; ++b) {
        is_there = changes_.before[b].state == ChangeState::kThere &&
                   stand_in_one_place(before_[b], now_[n]);
      }
      if (!is_there) changes_.arrived.push_back({n, evidence_before_[n]});
    }
  }

  // Rule 4: what is gone here and arrived there has moved.
  void join_moved() {
    std::vector<Pair> pairs;
    for (std::size_t b = 0; b < before_.size(); ++b) {
      if (changes_.before[b].state != ChangeState::kRemoved) continue;
      for (const ArrivedInstance& arrival : changes_.arrived) {
        if (before_[b].name != now_[arrival.now].name) continue;
        pairs.push_back({distance_m(before_[b], now_[arrival.now]), b, arrival.now});
      }
    }
    take_pairs(std::move(pairs), before_.size(), now_.size(), [&](const Pair& pair) {
      changes_.before[pair.a].state = ChangeState::kMoved;
      changes_.before[pair.a].now = pair.b;
      changes_.before[pair.a].evidence_now = evidence_before_[pair.b];
      std::erase_if(changes_.arrived,
                    [&](const ArrivedInstance& arrival) { return arrival.now == pair.b; });
    });
  }

  std::span<const PlacedInstance> before_, now_;
  const ChangeOptions& options_;
  std::vector<FreeSpaceEvidence> evidence_before_;  // of now_, by the map's depth
  std::vector<bool> was_there_in_past_;  // of now_: stands where such a thing stood in the past
  std::vector<bool> taken_;              // of now_
  Changes changes_;
};

}  // namespace

double FreeSpaceEvidence::decided_share() const {
  return static_cast<double>(decided) / static_cast<double>(std::max<std::size_t>(1, points));
}

double FreeSpaceEvidence::gone_share() const {
  return static_cast<double>(gone) / static_cast<double>(std::max<std::size_t>(1, decided));
}

double FreeSpaceEvidence::gone_share_of_whole() const {
  return static_cast<double>(gone) / static_cast<double>(std::max<std::size_t>(1, points));
}

FreeSpaceEvidence surface_evidence(std::span<const Vector3f> surface_world,
                                   std::span<const DepthView> views) {
  FreeSpaceEvidence evidence{.points = surface_world.size()};
  const PointVotes votes = count_votes(surface_world, views);
  for (const std::size_t decided : votes.decided_by_view) {
    if (decided > 0 && 4 * decided >= surface_world.size()) ++evidence.views;
  }
  for (std::size_t i = 0; i < surface_world.size(); ++i) {
    if (votes.seen[i] + votes.through[i] > 0) ++evidence.decided;
    if (votes.is_gone(i)) ++evidence.gone;
  }
  return evidence;
}

std::vector<Vector3f> remaining_surface(std::span<const Vector3f> surface_world,
                                        std::span<const DepthView> views) {
  const PointVotes votes = count_votes(surface_world, views);
  std::vector<Vector3f> remaining;
  for (std::size_t i = 0; i < surface_world.size(); ++i) {
    if (!votes.is_gone(i)) remaining.push_back(surface_world[i]);
  }
  return remaining;
}

PlacedInstance placed_instance(const Instance& instance, const geometry::OrientedBox& box_world,
                               std::span<const ObservedKeyframe> keyframes,
                               const GroundPlane& level,
                               std::vector<std::size_t>* supporting_keyframes) {
  constexpr double kFoot_m = 0.03;  // what a thing stands on reaches into its box
  constexpr float kSample_m = 0.04F;
  PlacedInstance thing{instance.name, box_world, {}};
  const geometry::RigidTransform box_from_world = box_world.world_from_box.inverse();
  std::set<VoxelKey> taken;
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    bool shows = false;
    for (const Detection& detection : keyframes[k].detections) {
      const std::string& name = detection.class_name;
      if (name != instance.name && !instance.names.contains(name)) continue;
      std::size_t inside = 0;
      for (const Vector3f& point : detection.surface.points) {
        const Vector3d point_world = keyframes[k].world_from_camera * point.cast<double>();
        const Vector3d point_box = box_from_world * point_world;
        if (((point_box.cwiseAbs() - 0.5 * box_world.size_m).array() > 0.01).any()) continue;
        if (point_box.z() < kFoot_m - 0.5 * box_world.size_m.z()) continue;
        if (level.height_m(point_world) < kFloorReach_m) continue;
        ++inside;
        // One point for each little cell, the first that comes.
        if (!taken.insert(voxel_of(point_world.cast<float>(), kSample_m)).second) continue;
        thing.surface_world.push_back(point_world.cast<float>());
      }
      shows = shows || 2 * inside >= detection.surface.points.size();
    }
    if (shows && supporting_keyframes != nullptr) supporting_keyframes->push_back(k);
  }
  return thing;
}

std::string_view to_string(ChangeState state) {
  switch (state) {
    case ChangeState::kThere:
      return "there";
    case ChangeState::kMoved:
      return "moved";
    case ChangeState::kShifted:
      return "shifted";
    case ChangeState::kRemoved:
      return "gone";
    case ChangeState::kUnobserved:
      return "not looked at";
  }
  return "";
}

Expected<void> ChangeOptions::validate() const {
  const auto check_share = [](double share, std::string_view what) -> Expected<void> {
    if (share >= 0 && share <= 1) return {};
    return fail("{} is {}; expected a share, 0 to 1", what, share);
  };
  ROOMWISE_RETURN_IF_ERROR(check_share(min_decided, "min_decided"));
  ROOMWISE_RETURN_IF_ERROR(check_share(min_gone, "min_gone"));
  ROOMWISE_RETURN_IF_ERROR(check_share(min_moved_gone_share, "min_moved_gone_share"));
  ROOMWISE_RETURN_IF_ERROR(check_share(min_shifted_gone_share, "min_shifted_gone_share"));
  ROOMWISE_RETURN_IF_ERROR(check_share(same_place, "same_place"));
  if (min_views < 1) return fail("min_views is {}; expected at least 1", min_views);
  if (!(min_moved_distance_m >= 0 && std::isfinite(min_moved_distance_m))) {
    return fail("min_moved_distance_m is {}; expected 0 m or more", min_moved_distance_m);
  }
  return {};
}

Changes find_changes(std::span<const PlacedInstance> before,
                     std::span<const DepthView> views_before, std::span<const PlacedInstance> now,
                     std::span<const DepthView> views_now, std::span<const PlacedInstance> past,
                     const ChangeOptions& options) {
  return ChangeFinder(before, now, options).find(views_before, views_now, past);
}

std::vector<std::optional<std::size_t>> match_by_name_and_place(
    std::span<const PlacedInstance> past, std::span<const PlacedInstance> things) {
  std::vector<Pair> pairs;
  for (std::size_t p = 0; p < past.size(); ++p) {
    for (std::size_t t = 0; t < things.size(); ++t) {
      if (past[p].name != things[t].name || !stand_in_one_place(past[p], things[t])) continue;
      pairs.push_back({distance_m(past[p], things[t]), p, t});
    }
  }
  std::vector<std::optional<std::size_t>> matches(past.size());
  take_pairs(std::move(pairs), past.size(), things.size(),
             [&](const Pair& pair) { matches[pair.a] = pair.b; });
  return matches;
}

}  // namespace roomwise::objects
