#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "roomwise/guide/places/home_map.h"
#include "roomwise/guide/way/route.h"

namespace roomwise::guide {

struct PlanOptions {
  RouteOptions room_for_a_person = {.comfort_m = 0.4};  // its farthest_goal_m is not used
  // Where nothing wider leads there: who turns their shoulders, m.
  double narrow_radius_m = 0.22;
  // From where the map says that somebody stands to free floor, where nothing is nearer, m.
  double farthest_start_m = 1.5;
  // Of two ways the one with fewer corners, where it is so far from what stands: a corner costs
  // somebody who is led a stop and a turn, m.
  double straight_m = 0.4;
  // A stretched arm from the body's middle, of somebody who leans over a table: what is so near to
  // the way's end is reached, m.
  double arm_m = 1.0;
  // A metre that the end lies nearer to the goal is worth so many metres of way.
  double reach_weight = 10;
  double into_room_m = 0.65;  // who has gone so far beyond the door is in the room

  [[nodiscard]] Expected<void> validate() const;
};

// How far somebody can be led.
enum class PlanStatus {
  kComplete,   // along free floor, to the goal
  kPartial,    // along free floor, not to its end: the rest is told by direction, or by rooms
  kRoomsOnly,  // the rooms that lie on the way, no more
  kNone,       // nothing
};

struct Plan {
  PlanStatus status = PlanStatus::kNone;
  Route route = {};        // of kComplete and kPartial: from where one stands; one point: stay here
  bool is_narrow = false;  // somewhere the shoulders must be turned
  // The goal's nearest point to the route's end (kComplete, kPartial).
  Eigen::Vector2d touch_plan = Eigen::Vector2d::Zero();
  // From the room at the route's end (kPartial) or around one (kRoomsOnly) to the goal's, both
  // included; empty where they are the same, or it is not known.
  std::vector<std::string> rooms = {};
  std::string because = {};  // why it is no more than this
};

// Always an answer: the whole way; where no safe one is known, one that ends as near as one gets;
// else the rooms. A thing is reached from the side where its edge is in reach of an arm, in its own
// room, that costs the least way; a room is reached beyond its door.
[[nodiscard]] Plan plan_way(const HomeMap& map, const UserLocation& from, const Goal& goal,
                            const PlanOptions& options = {});

}  // namespace roomwise::guide
