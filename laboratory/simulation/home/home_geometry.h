#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "laboratory/simulation/home/home_model.h"
#include "roomwise/base/expected.h"

// Where things of a home lie, as shapes that can be tested against one another.
namespace roomwise::simulation {

constexpr double kCarpetHeight = 0.05;  // flatter things lie under others

// What an upright thing takes up: a rectangle on the floor, turned by yaw_rad, and its heights.
struct Footprint {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  Eigen::Vector2d half_size = Eigen::Vector2d::Zero();
  double yaw_rad = 0;
  double bottom_m = 0, top_m = 0;

  // Counter-clockwise.
  [[nodiscard]] std::array<Eigen::Vector2d, 4> corners() const;
  // The upright rectangle around it.
  [[nodiscard]] Rectangle bounds() const;
  // To the nearest point of the rectangle; 0 inside.
  [[nodiscard]] double distance_m(const Eigen::Vector2d& point) const;
  [[nodiscard]] bool contains(const Eigen::Vector2d& point) const { return distance_m(point) <= 0; }
  [[nodiscard]] Footprint grown(double margin_m) const;
};

[[nodiscard]] Eigen::Vector2d center(const Rectangle& rectangle);
[[nodiscard]] Eigen::Vector2d size(const Rectangle& rectangle);
[[nodiscard]] double area_m2(const Rectangle& rectangle);
[[nodiscard]] bool contains(const Rectangle& rectangle, const Eigen::Vector2d& point);
[[nodiscard]] bool contains(const Rectangle& rectangle, const Footprint& footprint);
[[nodiscard]] Footprint as_footprint(const Rectangle& rectangle, double bottom_m, double top_m);

// Whether two rectangles, or two bodies, share more than a touch: they must go deeper into each
// other than `tolerance_m` (separating axis test).
[[nodiscard]] bool overlap_on_floor(const Footprint& a, const Footprint& b, double tolerance_m);
[[nodiscard]] bool bodies_overlap(const Footprint& a, const Footprint& b, double tolerance_m);

// Upright at a place, turned about z. Its front, -y of the object frame, then looks along
// facing(yaw_rad).
[[nodiscard]] geometry::RigidTransform upright_pose(const Eigen::Vector3d& bottom_center,
                                                    double yaw_rad);
[[nodiscard]] double yaw_of(const geometry::RigidTransform& world_from_object);
[[nodiscard]] Eigen::Vector2d facing(double yaw_rad);
[[nodiscard]] double yaw_facing(const Eigen::Vector2d& direction);

[[nodiscard]] Footprint footprint_of(const PlacedObject& object);

// The hole in the wall as a rectangle on the floor, as thick as the wall.
[[nodiscard]] Rectangle hole_of(const WallOpening& opening, double wall_thickness_m);

constexpr double kDoorLeafThickness = 0.04;

// Where the leaf hangs: on the wall's face on the side that it opens to.
[[nodiscard]] Eigen::Vector2d hinge_of(const Door& door, double wall_thickness_m);
// The leaf at the door's angle; absent for an open passage.
[[nodiscard]] std::optional<Footprint> leaf_of(const Door& door, double wall_thickness_m);
// The square that the leaf sweeps over between shut and at right angles; absent without a leaf.
[[nodiscard]] std::optional<Rectangle> swing_of(const Door& door, double wall_thickness_m);
// The floor in front of and behind a door that must stay free to walk through it, the hole
// included.
[[nodiscard]] Rectangle passage_of(const Door& door, double wall_thickness_m);

// What the curtains of a window take up in the room: the two halves, drawn aside; empty without.
[[nodiscard]] std::vector<Footprint> curtains_of(const Window& window, double wall_thickness_m);

// What the flight of stairs takes up on the lower storey.
[[nodiscard]] Rectangle flight_of(const Staircase& stairs);

// The room whose interior holds the point, or the nearest one.
[[nodiscard]] std::size_t room_at(const HomeModel& home, const Eigen::Vector2d& point);

// What doors, leaves, curtains and objects leave of the floor for a body between two heights.
[[nodiscard]] std::vector<Rectangle> floors_of(const HomeModel& home);
[[nodiscard]] std::vector<Footprint> obstacles_of(const HomeModel& home, double from_height_m,
                                                  double to_height_m);

[[nodiscard]] std::string_view name_of(RoomKind kind);
[[nodiscard]] std::string_view name_of(Scenario scenario);
// "bedroom", "living room" or "living-room", "bathroom" for a toilet; "moved-night".
[[nodiscard]] Expected<RoomKind> parse_room_kind(std::string_view name);
[[nodiscard]] Expected<Scenario> parse_scenario(std::string_view name);

}  // namespace roomwise::simulation
