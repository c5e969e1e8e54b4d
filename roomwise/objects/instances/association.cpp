#include <algorithm>
#include <map>
#include <set>
#include <string_view>

#include "roomwise/objects/instances/world_observation.h"
#include "roomwise/objects/kinds/kinds.h"

namespace roomwise::objects {
namespace {

constexpr double kReachOfLength = 0.6;
constexpr double kMinReach_m = 0.15;
constexpr double kSideBySide = 0.15;  // of the smaller group's pictures
constexpr int kMeanShifts = 3;

// A picture as one source looked at it.
using Look = std::pair<std::size_t, DetectionSource>;
Look look_of(const WorldObservation& observation) {
  return {observation.keyframe, observation.detection->source};
}

using Indices = std::vector<std::size_t>;

Eigen::Vector3d mean_middle(std::span<const WorldObservation> observations,
                            std::span<const std::size_t> group) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const std::size_t i : group) sum += observations[i].middle_world;
  return sum / static_cast<double>(group.size());
}

// Of the unassigned ones those within reach of a place.
Indices within(std::span<const WorldObservation> observations,
               std::span<const std::size_t> unassigned, const Eigen::Vector3d& place,
               double reach_m) {
  Indices near;
  for (const std::size_t i : unassigned) {
    if ((observations[i].middle_world - place).norm() <= reach_m) near.push_back(i);
  }
  return near;
}

// Of each look the one nearest to the place.
Indices nearest_of_each_look(std::span<const WorldObservation> observations,
                             std::span<const std::size_t> near, const Eigen::Vector3d& place) {
  std::map<Look, std::size_t> nearest;
  const auto distance_m = [&](std::size_t i) {
    return (observations[i].middle_world - place).norm();
  };
  for (const std::size_t i : near) {
    const auto [entry, is_new] = nearest.emplace(look_of(observations[i]), i);
    if (!is_new && distance_m(i) < distance_m(entry->second)) entry->second = i;
  }
  Indices chosen;
  for (const auto& [look, i] : nearest) chosen.push_back(i);
  std::ranges::sort(chosen);
  return chosen;
}

// The place where most key-frames have something, of the unassigned ones.
Eigen::Vector3d densest_place(std::span<const WorldObservation> observations,
                              std::span<const std::size_t> unassigned, double reach_m) {
  std::size_t most = 0, best = unassigned.front();
  for (const std::size_t i : unassigned) {
    std::set<std::size_t> keyframes;
    for (const std::size_t j :
         within(observations, unassigned, observations[i].middle_world, reach_m)) {
      keyframes.insert(observations[j].keyframe);
    }
    if (keyframes.size() <= most) continue;
    most = keyframes.size();
    best = i;
  }
  Eigen::Vector3d place = observations[best].middle_world;
  for (int i = 0; i < kMeanShifts; ++i) {
    const Indices near = within(observations, unassigned, place, reach_m);
    if (near.empty()) break;
    place = mean_middle(observations, near);
  }
  return place;
}

// The share of the smaller box that lies in the other.
double share_in_picture(const network::PixelBox& a, const network::PixelBox& b) {
  const float width = std::min(a.right, b.right) - std::max(a.left, b.left);
  const float height = std::min(a.bottom, b.bottom) - std::max(a.top, b.top);
  if (width <= 0 || height <= 0) return 0;
  return static_cast<double>(width * height / std::min(a.area(), b.area()));
}

std::vector<Indices> group_by_votes(std::span<const WorldObservation> observations,
                                    Indices unassigned, double reach_m) {
  std::vector<Indices> groups;
  while (!unassigned.empty()) {
    const Eigen::Vector3d place = densest_place(observations, unassigned, reach_m);
    const Indices near = within(observations, unassigned, place, reach_m);
    Indices group = nearest_of_each_look(observations, near, place);
    if (group.empty()) group = {unassigned.front()};  // shifts led away from all of them
    Indices rest;
    std::ranges::set_difference(unassigned, group, std::back_inserter(rest));
    unassigned = std::move(rest);
    groups.push_back(std::move(group));
  }
  return groups;
}

bool are_side_by_side(std::span<const WorldObservation> observations, const Indices& a,
                      const Indices& b) {
  constexpr double kApart = 0.3;  // of the smaller box lies in the other, at most
  std::map<Look, std::size_t> of_a;
  for (const std::size_t i : a) of_a.emplace(look_of(observations[i]), i);
  const auto both = std::ranges::count_if(b, [&](std::size_t i) {
    const auto other = of_a.find(look_of(observations[i]));
    return other != of_a.end() &&
           share_in_picture(observations[i].detection->box,
                            observations[other->second].detection->box) <= kApart;
  });
  return static_cast<double>(both) >
         kSideBySide * static_cast<double>(std::min(a.size(), b.size()));
}

// The nearest first, until no two are left that may be one.
void join_near(std::vector<Indices>& groups, std::span<const WorldObservation> observations,
               double reach_m) {
  while (true) {
    double nearest_m = reach_m;
    std::pair<std::size_t, std::size_t> best;
    for (std::size_t a = 0; a < groups.size(); ++a) {
      const Eigen::Vector3d of_a = mean_middle(observations, groups[a]);
      for (std::size_t b = a + 1; b < groups.size(); ++b) {
        const double apart_m = (mean_middle(observations, groups[b]) - of_a).norm();
        if (apart_m > nearest_m || are_side_by_side(observations, groups[a], groups[b])) continue;
        nearest_m = apart_m;
        best = {a, b};
      }
    }
    if (best.second == 0) return;
    Indices& into = groups[best.first];
    into.insert(into.end(), groups[best.second].begin(), groups[best.second].end());
    std::ranges::sort(into);
    groups.erase(groups.begin() + static_cast<std::ptrdiff_t>(best.second));
  }
}

}  // namespace

std::vector<ObservationCluster> associate(std::span<const WorldObservation> observations) {
  std::map<std::string_view, Indices> of_class;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    of_class[observations[i].detection->class_name].push_back(i);
  }
  std::vector<ObservationCluster> clusters;
  for (auto& [class_name, unassigned] : of_class) {
    const double reach_m = std::max(kMinReach_m, kReachOfLength * typical_length_m(class_name));
    std::vector<Indices> groups = group_by_votes(observations, std::move(unassigned), reach_m);
    join_near(groups, observations, reach_m);
    std::ranges::move(groups, std::back_inserter(clusters));
  }
  return clusters;
}

}  // namespace roomwise::objects
