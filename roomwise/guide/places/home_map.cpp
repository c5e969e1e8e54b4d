#include "roomwise/guide/places/home_map.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "roomwise/guide/places/surfaces.h"

namespace roomwise::guide {

using Eigen::Vector2d;

std::optional<std::string> HomeMap::room_at(const Vector2d& point_plan) const {
  return layout != nullptr ? layout->room_at(point_plan) : std::nullopt;
}

bool HomeMap::are_on_one_storey(const Vector2d& one, const Vector2d& other) const {
  return storeys == nullptr || storeys->at_plan(one) == storeys->at_plan(other);
}

bool is_well_inside(const HomeMap& map, const std::string& room, const Vector2d& place_plan) {
  constexpr double kBody_m = 0.25;
  constexpr int kDirections = 12;
  if (map.room_at(place_plan) != room) return false;
  for (int i = 0; i < kDirections; ++i) {
    const double heading = 2 * std::numbers::pi * i / kDirections;
    const Vector2d beside = place_plan + kBody_m * Vector2d(std::cos(heading), std::sin(heading));
    // Walls and things are of no room.
    const auto other = map.room_at(beside);
    if (other && *other != room) return false;
  }
  return true;
}

Vector2d Outline::nearest_to(const Vector2d& point_plan) const {
  const Eigen::Rotation2Dd turn(yaw_rad);
  const Vector2d local = turn.inverse() * (point_plan - middle_plan);
  return middle_plan + turn * Vector2d(local.cwiseMax(-size_m / 2).cwiseMin(size_m / 2));
}

double Outline::distance_m(const Vector2d& point_plan) const {
  return (nearest_to(point_plan) - point_plan).norm();
}

Goal Goal::of(const KnownThing& thing, const std::optional<CalendarTime>& today,
              std::span<const KnownThing> things) {
  Goal goal;
  goal.noun = {Noun::Kind::kThing, thing.name};
  goal.room = thing.room;
  goal.is_sure = thing.is_sure(today);
  goal.note = thing.note;
  if (thing.position_plan) {
    goal.outline = Outline{thing.position_plan->head<2>(), thing.size_m().head<2>(), thing.yaw_rad};
    goal.height_m = thing.position_plan->z();
    const KnownThing* const under = surface_under(thing, things);
    if (under != nullptr && under->is_sure(today)) goal.on = under->name;
  }
  return goal;
}

Goal Goal::of(const rooms::RoomExtent& room) {
  Goal goal;
  goal.kind = Kind::kRoom;
  goal.noun = {Noun::Kind::kRoom, room.name};
  goal.room = room.name;
  if (room.floor_m2 > 0) goal.outline = Outline{room.middle_plan};
  return goal;
}

Goal Goal::of(const rooms::Doorway& door) {
  Goal goal;
  goal.kind = Kind::kDoor;
  goal.noun = {Noun::Kind::kThing, "door"};
  goal.room = door.rooms[0];
  goal.outline = Outline{door.middle_plan, {door.width_m, 0}, door.direction_rad};
  return goal;
}

}  // namespace roomwise::guide
