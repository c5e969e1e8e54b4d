#include "roomwise/guide/places/surfaces.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "roomwise/objects/kinds/kinds.h"

namespace roomwise::guide {
namespace {

constexpr double kBoxError_m = 0.1;  // boxes end a hand's breadth early or late

double top_of_m(const KnownThing& thing) {
  return thing.position_plan->z() + thing.size_m().z() / 2;
}

double bottom_of_m(const KnownThing& thing) {
  return thing.position_plan->z() - thing.size_m().z() / 2;
}

// Of what a person could walk into.
bool is_between_ankle_and_head(const KnownThing& thing) {
  const ObstacleOptions heights;
  return top_of_m(thing) > heights.lowest_m && bottom_of_m(thing) < heights.highest_m;
}

}  // namespace

Outline outline_of(const KnownThing& thing) {
  return {thing.position_plan->head<2>(), thing.size_m().head<2>(), thing.yaw_rad};
}

bool stands_on(const KnownThing& thing, const KnownThing& surface) {
  if (&thing == &surface || !thing.position_plan) return false;
  const objects::Kind* const kind = objects::find_kind(thing.name);
  if (kind != nullptr && kind->stands_on_floor) return false;
  return std::abs(bottom_of_m(thing) - top_of_m(surface)) <= kBoxError_m &&
         outline_of(surface).distance_m(thing.position_plan->head<2>()) == 0;
}

const KnownThing* surface_under(const KnownThing& thing, std::span<const KnownThing> things) {
  const KnownThing* highest = nullptr;
  for (const KnownThing& one : things) {
    if (!one.position_plan || one.is_taught || !stands_on(thing, one)) continue;
    if (highest == nullptr || top_of_m(one) > top_of_m(*highest)) highest = &one;
  }
  return highest;
}

const KnownThing* thing_at(const Eigen::Vector2d& place_plan, const HomeMap& map) {
  const KnownThing* nearest = nullptr;
  std::tuple<double, double> min{kBoxError_m, 0};
  for (const KnownThing& thing : map.things) {
    if (!thing.position_plan || !is_between_ankle_and_head(thing)) continue;
    const std::tuple rank(outline_of(thing).distance_m(place_plan),
                          -thing.size_m().head<2>().prod());
    if (rank > min || surface_under(thing, map.things) != nullptr) continue;
    min = rank;
    nearest = &thing;
  }
  return nearest;
}

const KnownThing* nearest_sure_thing(const Eigen::Vector2d& place_plan, double within_m,
                                     const HomeMap& map) {
  const KnownThing* nearest = nullptr;
  const auto here = map.room_at(place_plan);
  for (const KnownThing& thing : map.things) {
    if (!thing.position_plan || !thing.is_sure(map.today)) continue;
    if (here && thing.room && thing.room != here) continue;
    const double distance_m = outline_of(thing).distance_m(place_plan);
    if (distance_m >= within_m) continue;
    within_m = distance_m;
    nearest = &thing;
  }
  return nearest;
}

const KnownThing* thing_between(const Eigen::Vector2d& from, const Goal& goal, const HomeMap& map) {
  constexpr double kStep_m = 0.05;
  const Eigen::Vector2d towards = goal.outline->nearest_to(from) - from;
  for (double ahead_m = 0; ahead_m < towards.norm(); ahead_m += kStep_m) {
    const Eigen::Vector2d place = from + ahead_m * towards.normalized();
    for (const KnownThing& thing : map.things) {
      const bool is_known = thing.position_plan && thing.is_sure(map.today);
      if (!is_known || thing.name == goal.noun.name) continue;
      const Outline outline = outline_of(thing);
      // The goal itself by another name: the front door as the way out.
      const bool is_goal = outline.middle_plan == goal.outline->middle_plan &&
                           outline.size_m == goal.outline->size_m;
      if (!is_goal && outline.distance_m(place) < kBoxError_m) return &thing;
    }
  }
  return nullptr;
}

const KnownThing* sure_thing_of(const ObstacleAhead& obstacle, const Pose& from,
                                const HomeMap& map) {
  if (map.floor == nullptr || from.sigma_m > kBoxError_m || obstacle.all.empty()) return nullptr;
  const bool is_explained =
      std::ranges::all_of(obstacle.all, [&](const Eigen::Vector2d& ahead_left_m) {
        const Eigen::Vector2d place = from.place_of(ahead_left_m);
        const KnownThing* const thing = thing_at(place, map);
        return thing != nullptr && thing->is_sure(map.today) && is_on_map(place, *map.floor);
      });
  return is_explained ? thing_at(from.place_of(obstacle.ahead_left_m), map) : nullptr;
}

}  // namespace roomwise::guide
