#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>

#include "roomwise/fusion/floor_grid.h"
#include "roomwise/fusion/storeys.h"
#include "roomwise/guide/places/places.h"
#include "roomwise/guide/words/phrasebook.h"
#include "roomwise/rooms/layout/room_layout.h"

namespace roomwise::guide {

// What a home knows of floor, rooms and things; any of it may be missing. What it points to must
// outlive it. All on the plan (see Storeys), m.
struct HomeMap {
  const fusion::FloorGrid* floor = nullptr;
  const rooms::RoomLayout* layout = nullptr;
  std::span<const rooms::Doorway> doorways = {};  // where rooms meet: doors, and borders of others
  std::span<const KnownThing> things = {};
  const fusion::Storeys* storeys = nullptr;  // null: one, whose plan is the gravity-aligned frame
  std::optional<CalendarTime> today = std::nullopt;  // a guide's; unknown: no belief ages

  [[nodiscard]] std::optional<std::string> room_at(const Eigen::Vector2d& point_plan) const;
  // Else the plan tells neither direction nor distance from the one to the other.
  [[nodiscard]] bool are_on_one_storey(const Eigen::Vector2d& one,
                                       const Eigen::Vector2d& other) const;
};

// Whether somebody who stands there is in the room with their whole body: a layout tells rooms
// apart to a foot's length, and who stands in a door's frame is in neither.
[[nodiscard]] bool is_well_inside(const HomeMap& map, const std::string& room,
                                  const Eigen::Vector2d& place_plan);

// What something takes up on the floor: a rectangle, turned about its middle.
struct Outline {
  Eigen::Vector2d middle_plan = Eigen::Vector2d::Zero();
  Eigen::Vector2d size_m = Eigen::Vector2d::Zero();
  double yaw_rad = 0;  // from x to the side of size_m.x()

  [[nodiscard]] Eigen::Vector2d nearest_to(const Eigen::Vector2d& point_plan) const;
  // 0 inside.
  [[nodiscard]] double distance_m(const Eigen::Vector2d& point_plan) const;
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

}  // namespace roomwise::guide
