#include "laboratory/simulation/home/home_geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace roomwise::simulation {
namespace {

constexpr double kPassageDepth = 0.8;

Eigen::Vector2d axis(double yaw_rad) {
  return {std::cos(yaw_rad), std::sin(yaw_rad)};
}

// Half the length of a footprint's shadow on a line.
double reach_along(const Footprint& footprint, const Eigen::Vector2d& line) {
  const Eigen::Vector2d x = axis(footprint.yaw_rad);
  const Eigen::Vector2d y(-x.y(), x.x());
  return std::abs(x.dot(line)) * footprint.half_size.x() +
         std::abs(y.dot(line)) * footprint.half_size.y();
}

bool separated_along(const Footprint& a, const Footprint& b, const Eigen::Vector2d& line,
                     double tolerance_m) {
  const double apart = std::abs(line.dot(b.center - a.center));
  return apart >= reach_along(a, line) + reach_along(b, line) - tolerance_m;
}

// The wall's direction and the side that the leaf opens to.
std::pair<Eigen::Vector2d, Eigen::Vector2d> directions_of(const Door& door) {
  const Eigen::Vector2d along =
      door.opening.along_x ? Eigen::Vector2d::UnitX() : Eigen::Vector2d::UnitY();
  const Eigen::Vector2d across =
      door.opening.along_x ? Eigen::Vector2d::UnitY() : Eigen::Vector2d::UnitX();
  return {along, door.opens_to_positive ? across : Eigen::Vector2d(-across)};
}

Rectangle around(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return {a.cwiseMin(b), a.cwiseMax(b)};
}

constexpr std::array<std::pair<RoomKind, std::string_view>, 7> kRoomNames{{
    {RoomKind::kBedroom, "bedroom"},
    {RoomKind::kKitchen, "kitchen"},
    {RoomKind::kToilet, "toilet"},
    {RoomKind::kLivingRoom, "living room"},
    {RoomKind::kDiningRoom, "dining room"},
    {RoomKind::kHall, "hall"},
    {RoomKind::kStudy, "study"},
}};

constexpr std::array<std::pair<Scenario, std::string_view>, 5> kScenarioNames{{
    {Scenario::kDay, "day"},
    {Scenario::kEvening, "evening"},
    {Scenario::kNight, "night"},
    {Scenario::kMoved, "moved"},
    {Scenario::kMovedNight, "moved-night"},
}};

}  // namespace

std::array<Eigen::Vector2d, 4> Footprint::corners() const {
  const Eigen::Vector2d x = axis(yaw_rad) * half_size.x();
  const Eigen::Vector2d y = Eigen::Vector2d(-std::sin(yaw_rad), std::cos(yaw_rad)) * half_size.y();
  return {center - x - y, center + x - y, center + x + y, center - x + y};
}

Rectangle Footprint::bounds() const {
  const Eigen::Vector2d reach(reach_along(*this, Eigen::Vector2d::UnitX()),
                              reach_along(*this, Eigen::Vector2d::UnitY()));
  return {center - reach, center + reach};
}

double Footprint::distance_m(const Eigen::Vector2d& point) const {
  const Eigen::Vector2d x = axis(yaw_rad);
  const Eigen::Vector2d offset = point - center;
  const Eigen::Vector2d local(std::abs(x.dot(offset)),
                              std::abs(x.x() * offset.y() - x.y() * offset.x()));
  return (local - half_size).cwiseMax(0).norm();
}

Footprint Footprint::grown(double margin_m) const {
  Footprint result = *this;
  result.half_size.array() += margin_m;
  return result;
}

Eigen::Vector2d center(const Rectangle& rectangle) {
  return (rectangle.min + rectangle.max) / 2;
}

Eigen::Vector2d size(const Rectangle& rectangle) {
  return rectangle.max - rectangle.min;
}

double area_m2(const Rectangle& rectangle) {
  return size(rectangle).prod();
}

bool contains(const Rectangle& rectangle, const Eigen::Vector2d& point) {
  return (point.array() >= rectangle.min.array()).all() &&
         (point.array() <= rectangle.max.array()).all();
}

bool contains(const Rectangle& rectangle, const Footprint& footprint) {
  const Rectangle bounds = footprint.bounds();
  return contains(rectangle, bounds.min) && contains(rectangle, bounds.max);
}

Footprint as_footprint(const Rectangle& rectangle, double bottom_m, double top_m) {
  return {center(rectangle), size(rectangle) / 2, 0, bottom_m, top_m};
}

bool overlap_on_floor(const Footprint& a, const Footprint& b, double tolerance_m) {
  for (const double yaw : {a.yaw_rad, b.yaw_rad}) {
    const Eigen::Vector2d x = axis(yaw);
    if (separated_along(a, b, x, tolerance_m)) return false;
    if (separated_along(a, b, {-x.y(), x.x()}, tolerance_m)) return false;
  }
  return true;
}

bool bodies_overlap(const Footprint& a, const Footprint& b, double tolerance_m) {
  const double common = std::min(a.top_m, b.top_m) - std::max(a.bottom_m, b.bottom_m);
  return common > tolerance_m && overlap_on_floor(a, b, tolerance_m);
}

geometry::RigidTransform upright_pose(const Eigen::Vector3d& bottom_center, double yaw_rad) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ())), bottom_center};
}

double yaw_of(const geometry::RigidTransform& world_from_object) {
  const Eigen::Vector3d x = world_from_object.rotation * Eigen::Vector3d::UnitX();
  return std::atan2(x.y(), x.x());
}

Eigen::Vector2d facing(double yaw_rad) {
  return {std::sin(yaw_rad), -std::cos(yaw_rad)};
}

double yaw_facing(const Eigen::Vector2d& direction) {
  return std::atan2(direction.x(), -direction.y());
}

Footprint footprint_of(const PlacedObject& object) {
  const Eigen::Vector3d& bottom = object.world_from_object.translation;
  return {bottom.head<2>(), object.size_m.head<2>() / 2, yaw_of(object.world_from_object),
          bottom.z(), bottom.z() + object.size_m.z()};
}

Rectangle hole_of(const WallOpening& opening, double wall_thickness_m) {
  Eigen::Vector2d half(opening.width_m / 2, wall_thickness_m / 2);
  if (!opening.along_x) std::swap(half.x(), half.y());
  return {opening.center - half, opening.center + half};
}

Eigen::Vector2d hinge_of(const Door& door, double wall_thickness_m) {
  const auto [along, across] = directions_of(door);
  const double side = door.hinge_at_min ? -1 : 1;
  return door.opening.center + along * (side * door.opening.width_m / 2) +
         across * (wall_thickness_m / 2);
}

std::optional<Footprint> leaf_of(const Door& door, double wall_thickness_m) {
  if (!door.has_leaf) return std::nullopt;
  const auto [along, across] = directions_of(door);
  const Eigen::Vector2d shut = door.hinge_at_min ? along : Eigen::Vector2d(-along);
  const Eigen::Vector2d direction =
      shut * std::cos(door.open_rad) + across * std::sin(door.open_rad);
  Footprint leaf;
  leaf.half_size = {door.opening.width_m / 2, kDoorLeafThickness / 2};
  leaf.center = hinge_of(door, wall_thickness_m) + direction * leaf.half_size.x();
  leaf.yaw_rad = std::atan2(direction.y(), direction.x());
  leaf.top_m = door.opening.top_m;
  return leaf;
}

std::optional<Rectangle> swing_of(const Door& door, double wall_thickness_m) {
  if (!door.has_leaf) return std::nullopt;
  const auto [along, across] = directions_of(door);
  const Eigen::Vector2d hinge = hinge_of(door, wall_thickness_m);
  const double width = door.opening.width_m;
  const double side = door.hinge_at_min ? 1 : -1;
  return around(hinge - along * (side * kDoorLeafThickness),
                hinge + along * (side * width) + across * (width + kDoorLeafThickness));
}

Rectangle passage_of(const Door& door, double wall_thickness_m) {
  Rectangle passage = hole_of(door.opening, wall_thickness_m);
  const int across = door.opening.along_x ? 1 : 0;
  passage.min[across] -= kPassageDepth;
  passage.max[across] += kPassageDepth;
  return passage;
}

std::vector<Footprint> curtains_of(const Window& window, double wall_thickness_m) {
  if (!window.has_curtains) return {};
  constexpr double kDepth = 0.11, kBeyondWindow = 0.17, kOpenShare = 0.71, kFromFloor = 0.04;
  const WallOpening& hole = window.opening;
  const int along = hole.along_x ? 0 : 1;
  const double inner = hole.width_m / 2 * kOpenShare;
  const double outer = hole.width_m / 2 + kBeyondWindow;
  const double into_room = window.outside_is_positive ? -1 : 1;
  std::vector<Footprint> curtains;
  for (const double side : {-1.0, 1.0}) {
    Footprint curtain;
    curtain.center = hole.center;
    curtain.center[along] += side * (inner + outer) / 2;
    curtain.center[1 - along] += into_room * (wall_thickness_m + kDepth) / 2;
    curtain.half_size[along] = (outer - inner) / 2;
    curtain.half_size[1 - along] = kDepth / 2;
    curtain.bottom_m = kFromFloor;
    curtain.top_m = hole.top_m + 0.15;
    curtains.push_back(curtain);
  }
  return curtains;
}

Rectangle flight_of(const Staircase& stairs) {
  const Eigen::Vector2d aside = stairs.width_m / 2 * Eigen::Vector2d(-stairs.up.y(), stairs.up.x());
  return around(stairs.foot - aside, stairs.foot + stairs.run_m() * stairs.up + aside);
}

std::size_t room_at(const HomeModel& home, const Eigen::Vector2d& point) {
  std::size_t nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < home.rooms.size(); ++i) {
    const double distance = as_footprint(home.rooms[i].interior, 0, 0).distance_m(point);
    if (distance >= least) continue;
    least = distance;
    nearest = i;
  }
  return nearest;
}

std::vector<Rectangle> floors_of(const HomeModel& home) {
  std::vector<Rectangle> floors;
  for (const Room& room : home.rooms) floors.push_back(room.interior);
  for (const Door& door : home.doors) {
    if (door.other_room) floors.push_back(hole_of(door.opening, home.wall_thickness_m));
  }
  return floors;
}

std::vector<Footprint> obstacles_of(const HomeModel& home, double from_height_m,
                                    double to_height_m) {
  std::vector<Footprint> obstacles;
  const auto add = [&](const Footprint& footprint) {
    if (footprint.top_m > from_height_m && footprint.bottom_m < to_height_m) {
      obstacles.push_back(footprint);
    }
  };
  for (const PlacedObject& object : home.objects) add(footprint_of(object));
  for (const Window& window : home.windows) {
    for (const Footprint& curtain : curtains_of(window, home.wall_thickness_m)) add(curtain);
  }
  // Above the stairs one would fall; below, they stand in the way: both are walked on their own.
  for (const Staircase& stairs : home.stairs) {
    add(as_footprint(flight_of(stairs), 0, home.ceiling_height_m));
  }
  for (const Room& room : home.rooms) {
    if (room.open_floor) add(as_footprint(*room.open_floor, 0, home.ceiling_height_m));
  }
  for (const Door& door : home.doors) {
    if (!door.other_room) continue;  // always shut: a part of the wall
    if (const auto leaf = leaf_of(door, home.wall_thickness_m)) add(*leaf);
  }
  return obstacles;
}

std::string_view name_of(RoomKind kind) {
  return std::ranges::find(kRoomNames, kind, &std::pair<RoomKind, std::string_view>::first)->second;
}

std::string_view name_of(Scenario scenario) {
  return std::ranges::find(kScenarioNames, scenario, &std::pair<Scenario, std::string_view>::first)
      ->second;
}

Expected<RoomKind> parse_room_kind(std::string_view name) {
  std::string plain(name);
  std::ranges::replace(plain, '-', ' ');
  if (plain == "bathroom") return RoomKind::kToilet;
  for (const auto& [kind, known] : kRoomNames) {
    if (plain == known) return kind;
  }
  return fail(
      "'{}' is no kind of room; expected bedroom, kitchen, toilet, living-room, dining-room, hall "
      "or study",
      name);
}

Expected<Scenario> parse_scenario(std::string_view name) {
  for (const auto& [scenario, known] : kScenarioNames) {
    if (name == known) return scenario;
  }
  return fail("'{}' is no scenario; expected day, evening, night, moved or moved-night", name);
}

}  // namespace roomwise::simulation
