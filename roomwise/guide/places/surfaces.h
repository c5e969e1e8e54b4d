#pragma once

#include <span>

#include "roomwise/guide/places/home_map.h"
#include "roomwise/guide/places/obstacle.h"
#include "roomwise/guide/places/places.h"

// What lies on what, and what stands where.
namespace roomwise::guide {

// Of a thing that has a place.
[[nodiscard]] Outline outline_of(const KnownThing& thing);

// What does not stand on the floor, and whose middle lies over the surface's box, its bottom no
// more than a hand's breadth from the top of that. `surface` has a place.
[[nodiscard]] bool stands_on(const KnownThing& thing, const KnownThing& surface);

// What the thing lies on; of several the one whose top is highest; nullptr: nothing is known.
[[nodiscard]] const KnownThing* surface_under(const KnownThing& thing,
                                              std::span<const KnownThing> things);

// What of the map stands there, give or take a hand's breadth: of what is between ankle and head
// and does not lie on something else the nearest, else the largest. nullptr: nothing is known.
[[nodiscard]] const KnownThing* thing_at(const Eigen::Vector2d& place_plan, const HomeMap& map);

// Of the sure things, those of another room than the place's apart, the nearest that is nearer than
// that; nullptr: there is none.
[[nodiscard]] const KnownThing* nearest_sure_thing(const Eigen::Vector2d& place_plan,
                                                   double within_m, const HomeMap& map);

// What stands between a place and a goal that cannot be reached from there, whose outline is known:
// the first sure thing on the straight line, as broad as a hand; nullptr: nothing that is known.
[[nodiscard]] const KnownThing* thing_between(const Eigen::Vector2d& from, const Goal& goal,
                                              const HomeMap& map);

// What the obstacle surely is that was seen from there: of the sure things of the map the nearest,
// where the place is sure, too, and nothing in the corridor may be anything else. nullptr: it may.
[[nodiscard]] const KnownThing* sure_thing_of(const ObstacleAhead& obstacle, const Pose& from,
                                              const HomeMap& map);

}  // namespace roomwise::guide
