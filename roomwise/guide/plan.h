#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomwise/fusion/floor_grid.h"
#include "roomwise/fusion/storeys.h"
#include "roomwise/guide/phrasebook.h"
#include "roomwise/guide/places.h"
#include "roomwise/guide/route.h"
#include "roomwise/rooms/layout/room_layout.h"

namespace roomwise::guide {

// What a home knows of floor, rooms and things; any of it may be missing. What it points to must
// outlive it. All in the gravity-aligned frame, m.
struct HomeMap {
  const fusion::FloorGrid* floor = nullptr;
  const rooms::RoomLayout* layout = nullptr;
  std::span<const rooms::Doorway> doorways = {};  // where rooms meet: doors, and borders of others
  std::span<const KnownThing> things = {};
  const fusion::Storeys* storeys = nullptr;  // null: one; else all lies on the plan (see Storeys)
  std::optional<CalendarTime> today = std::nullopt;  // a guide's; unknown: no belief ages

  [[nodiscard]] std::optional<std::string> room_at(const Eigen::Vector2d& point_gravity) const;
};

// What something takes up on the floor: a rectangle, turned about its middle.
struct Outline {
  Eigen::Vector2d middle_gravity = Eigen::Vector2d::Zero();
  Eigen::Vector2d size_m = Eigen::Vector2d::Zero();
  double yaw_rad = 0;  // from x to the side of size_m.x()

  [[nodiscard]] Eigen::Vector2d nearest_to(const Eigen::Vector2d& point_gravity) const;
  // 0 inside.
  [[nodiscard]] double distance_m(const Eigen::Vector2d& point_gravity) const;
};

// The way out as homes and catalogues call it.
inline constexpr const char* kNameOfWayOut = "way out";

// Where somebody wants to be led.
struct Goal {
  enum class Kind { kThing, kRoom, kDoor, kWayOut, kSpot };
  Kind kind = Kind::kThing;
  Noun noun;                        // what it is called
  std::optional<Outline> outline;   // of a room its middle; absent: not known
  std::optional<std::string> room;  // in which it lies, or which it is
  std::optional<double> height_m;   // of a thing's middle over the floor
  std::string on;                   // the thing that it lies on; empty: not known
  bool is_sure = true;              // that it is there
  std::string note;                 // a helper's, to be said who is there; may be empty

  // It is come up to, and not stood on.
  [[nodiscard]] bool is_solid() const { return kind == Kind::kThing || kind == Kind::kWayOut; }

  // `things`: of the home, of which it may lie on one.
  [[nodiscard]] static Goal of(const KnownThing& thing, const std::optional<CalendarTime>& today,
                               std::span<const KnownThing> things = {});
  [[nodiscard]] static Goal of(const rooms::RoomExtent& room);
  [[nodiscard]] static Goal of(const rooms::Doorway& door);
};

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
enum class Reach {
  kWhole,    // along free floor, to the goal
  kNear,     // along free floor, not to its end: the rest is told by direction, or by rooms
  kRooms,    // the rooms that lie on the way, no more
  kUnknown,  // nothing
};

struct Plan {
  Reach reach = Reach::kUnknown;
  Route route = {};        // of kWhole and kNear: from where one stands; one point: stay here
  bool is_narrow = false;  // somewhere the shoulders must be turned
  // The goal's nearest point to the route's end (kWhole, kNear).
  Eigen::Vector2d touch_gravity = Eigen::Vector2d::Zero();
  // From the room at the route's end (kNear) or around one (kRooms) to the goal's, both included;
  // empty where they are the same, or it is not known.
  std::vector<std::string> rooms = {};
  std::string because = {};  // why it is no more than this
};

// Always an answer: the whole way; where no safe one is known, one that ends as near as one gets;
// else the rooms. A thing is reached from the side where its edge is in reach of an arm, in its own
// room, that costs the least way; a room is reached beyond its door.
[[nodiscard]] Plan plan_way(const HomeMap& map, const UserLocation& from, const Goal& goal,
                            const PlanOptions& options = {});

}  // namespace roomwise::guide
