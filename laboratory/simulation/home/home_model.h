#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "roomwise/base/color.h"
#include "roomwise/geometry/rigid_transform.h"

// A made-up home as values: what stands where, of what it is made, what is lit. Made by
// generate_home(), changed by apply_scenario(), drawn by the renderer, written as ground truth.
//
// World frame: z up, the lowest floor is z = 0, lengths in metres. Walls run along x and y. A home
// of several storeys is planned with them drawn side by side, each with its floor at z = 0 (the
// plan frame); in_world() puts them above one another. Of one storey the two are the same.
namespace roomwise::simulation {

enum class RoomKind { kBedroom, kKitchen, kToilet, kLivingRoom, kDiningRoom, kHall, kStudy };

enum class Scenario { kDay, kEvening, kNight, kMoved, kMovedNight };

struct Rectangle {
  Eigen::Vector2d min = Eigen::Vector2d::Zero();
  Eigen::Vector2d max = Eigen::Vector2d::Zero();
};

// What a floor, wall or ceiling is covered with; the pattern is made from the seed.
enum class Material { kPaint, kWallpaper, kPlaster, kTiles, kBoards, kParquet, kCarpet, kStone };
struct Finish {
  Material material = Material::kPaint;
  Rgb8 color{230, 225, 215};   // sRGB, the main colour
  Rgb8 accent{200, 195, 185};  // joints, stripes, grain
  double scale_m = 0.3;        // a tile's or board's width, a wallpaper's repeat
  std::uint64_t seed = 0;
};

struct Room {
  std::string name;  // unique in the home: "bedroom", "second bedroom"
  RoomKind kind = RoomKind::kHall;
  Rectangle interior;  // between the inner faces of its walls
  Finish floor, walls, ceiling;
  // A tiled strip of wall (kitchen splashback, bathroom) up to this height; absent: none.
  std::optional<Finish> tiled_walls;
  double tiled_from_m = 0, tiled_to_m = 0;
  std::size_t storey = 0;  // index into HomeModel::storeys
  double floor_m = 0;      // in the world; 0 in a plan
  // Where its floor or its ceiling is open for stairs.
  std::optional<Rectangle> open_floor, open_ceiling;
};

// A hole in a wall: its middle on the wall's middle plane, and the direction of the wall.
struct WallOpening {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  bool along_x = true;  // the wall runs along x (else y)
  double width_m = 0.9;
  double bottom_m = 0;  // above the floor; 0 for doors
  double top_m = 2.05;
  double floor_m = 0;  // of its room, as Room::floor_m
};

struct Door {
  WallOpening opening;
  std::size_t room = 0;                   // index into HomeModel::rooms
  std::optional<std::size_t> other_room;  // absent: the front door, always shut
  bool has_leaf = true;                   // false: an open passage
  bool hinge_at_min = true;               // at the end of lower x (or y)
  bool opens_to_positive = true;          // the leaf turns towards positive y (or x)
  double open_rad = 1.4;                  // 0: shut
  Rgb8 color{235, 232, 225};
};

struct Window {
  WallOpening opening;
  std::size_t room = 0;
  bool outside_is_positive = true;  // outside lies towards positive y (or x)
  bool has_curtains = false;
};

struct WallPicture {
  std::size_t room = 0;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();   // on the wall's face
  Eigen::Vector2d normal = Eigen::Vector2d::UnitX();  // into the room
  double width_m = 0.6, height_m = 0.4;
  std::uint64_t seed = 0;  // of what it shows
};

// A light other than sun and sky. Whether it is lit is the scenario's matter.
struct Light {
  std::size_t room = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  double radius_m = 0.1;
  double lumens = 800;
  double color_temperature_k = 2900;
  bool is_on = false;
  bool is_ceiling_panel = false;      // else a lamp
  std::optional<std::size_t> object;  // the lamp that it belongs to, index into objects
};

// A piece of furniture or a thing. Object frame: origin in the middle of the bottom of its bounding
// box, z up, x to the right for one who looks at its front; its front looks along -y.
struct PlacedObject {
  std::string name;   // unique in the home: "bed", "chair 3"
  std::string kind;   // of the furniture catalogue: "bed", "lamp", "wardrobe", ...
  std::string model;  // FurnitureModel::id
  std::size_t room = 0;
  geometry::RigidTransform world_from_object;        // upright: a turn about z
  Eigen::Vector3d size_m = Eigen::Vector3d::Ones();  // along x, y, z of the object frame
  std::optional<std::size_t> stands_on;  // the object that carries it, index into objects
  bool is_small = false;                 // may be moved between surfaces
  bool is_movable = false;               // chairs, bins, lamps: shifted when things are moved
};

struct Storey {
  Eigen::Vector3d world_from_plan = Eigen::Vector3d::Zero();  // what moves it where it belongs
};

// A straight flight between two storeys, with a rail on its open sides.
struct Staircase {
  std::size_t lower_room = 0, upper_room = 0;      // index into HomeModel::rooms
  Eigen::Vector2d foot = Eigen::Vector2d::Zero();  // middle of the first riser, lower storey's plan
  Eigen::Vector2d up = Eigen::Vector2d::UnitX();   // the way that it climbs; unit length
  double width_m = 1;
  int steps = 16;  // risers; the last one ends on the upper floor
  double rise_m = 0.18, going_m = 0.27;
  bool has_left_rail = false, has_right_rail = false;  // for who climbs
  Finish finish;

  // Along the floor, from the first riser to the last.
  [[nodiscard]] double run_m() const { return (steps - 1) * going_m; }
  [[nodiscard]] double height_m() const { return steps * rise_m; }
};

struct HomeModel {
  std::uint64_t seed = 0;
  Scenario scenario = Scenario::kDay;
  double ceiling_height_m = 2.6;
  double wall_thickness_m = 0.12;
  std::vector<Storey> storeys{Storey{}};
  std::vector<Room> rooms;
  std::vector<Staircase> stairs;
  std::vector<Door> doors;
  std::vector<Window> windows;
  std::vector<WallPicture> pictures;
  std::vector<Light> lights;
  std::vector<PlacedObject> objects;
  // Where the sun stands at this scenario, if it is up: towards the sun, world frame, unit length.
  std::optional<Eigen::Vector3d> sun_direction;
};

}  // namespace roomwise::simulation
