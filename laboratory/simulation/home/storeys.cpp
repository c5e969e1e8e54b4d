#include "laboratory/simulation/home/storeys.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "laboratory/simulation/home/finishes.h"
#include "laboratory/simulation/home/floor_plan.h"
#include "laboratory/simulation/home/furnishing.h"
#include "laboratory/simulation/home/home_geometry.h"
#include "laboratory/simulation/home/scenario.h"
#include "roomwise/base/random.h"

namespace roomwise::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSlab_m = 0.25;       // from a ceiling to the floor above it
constexpr double kStairHall_m = 2.3;   // wide
constexpr double kFlight_m = 0.95;     // of it the flight
constexpr double kLanding_m = 1.25;    // before the first and behind the last step
constexpr double kStep_m = 0.63;       // two rises and a going: a person's pace (Blondel)
constexpr double kBetweenPlans_m = 3;  // storeys drawn side by side
constexpr double kPassage_m = 1.0;     // into the stair hall
constexpr double kStand_m = 0.45;      // from the stairs' edge to who stands before them

// The hall that holds the stairs, beyond the wall with the front door: `out` leads away from the
// flat, `aside` to its left. Lengths from the middle of that wall's outer face.
struct StairHall {
  Vector2d wall = Vector2d::Zero();  // middle of the front door, on the wall's middle plane
  Vector2d out = Vector2d::UnitX();
  double side = 1;  // of the flight: 1: to the left for who looks out
  double thickness_m = 0.12;
  double run_m = 0;

  [[nodiscard]] Vector2d aside() const { return {-out.y(), out.x()}; }
  [[nodiscard]] double length_m() const { return 2 * kLanding_m + run_m; }
  [[nodiscard]] Vector2d at(double out_m, double aside_m) const {
    return wall + (thickness_m / 2 + out_m) * out + aside_m * aside();
  }
  [[nodiscard]] Rectangle part(double from_out_m, double to_out_m) const {
    const Vector2d a = at(from_out_m, -kStairHall_m / 2), b = at(to_out_m, kStairHall_m / 2);
    return {a.cwiseMin(b), a.cwiseMax(b)};
  }
};

Door& front_door(HomeModel& home) {
  return *std::ranges::find_if(home.doors, [](const Door& door) { return !door.other_room; });
}

bool has_front_door(const HomeModel& home) {
  return std::ranges::any_of(home.doors, [](const Door& door) { return !door.other_room; });
}

Vector2d outward_of(const Door& front) {
  const Vector2d across = front.opening.along_x ? Vector2d::UnitY() : Vector2d::UnitX();
  return front.opens_to_positive ? Vector2d(-across) : across;
}

// What people have above: where one sleeps, washes and works.
std::vector<RoomKind> upper_rooms(std::uint64_t seed) {
  RandomStream random(seed, {0x7570706572});
  std::vector<RoomKind> rooms{RoomKind::kHall, RoomKind::kBedroom, RoomKind::kToilet};
  if (random.uniform() < 0.5) rooms.push_back(RoomKind::kBedroom);
  if (random.uniform() < 0.5) rooms.push_back(RoomKind::kStudy);
  return rooms;
}

// One whose way in lies on the same side.
Expected<HomeModel> plan_upper_storey(std::uint64_t seed, const Vector2d& out) {
  constexpr std::uint64_t kTries = 60;
  for (std::uint64_t i = 0; i < kTries; ++i) {
    RandomStream random(seed, {0x73746f726579, i});
    auto home = plan_floor(random.next() >> 1U, upper_rooms(seed));
    if (!home) continue;  // not every seed has a flat of these rooms
    if (has_front_door(*home) && outward_of(front_door(*home)).dot(out) > 0.5) return home;
  }
  return fail("no upper storey was found that can stand on the lower one; try another seed");
}

// The front door becomes the passage to the stairs, and no window looks into them.
void open_to(const StairHall& hall, std::size_t stair_room, HomeModel& home) {
  Door& passage = front_door(home);
  passage.other_room = stair_room;
  passage.has_leaf = false;
  passage.open_rad = 0;
  passage.opening.width_m = kPassage_m;
  const Footprint walls = as_footprint(hall.part(-0.3, hall.length_m()), 0, 3).grown(0.2);
  std::erase_if(home.windows, [&](const Window& window) {
    return overlap_on_floor(
        walls, as_footprint(simulation::hole_of(window.opening, home.wall_thickness_m), 0, 3), 0);
  });
}

Room stair_room(std::string name, const StairHall& hall, std::uint64_t seed, std::size_t index) {
  Room room;
  room.name = std::move(name);
  room.kind = RoomKind::kHall;
  room.interior = hall.part(0, hall.length_m());
  finish_room(seed, index, room);
  return room;
}

void add_panel(HomeModel& home, std::size_t room, const Vector2d& place, double lumens) {
  Light light;
  light.room = room;
  light.position = {place.x(), place.y(), home.ceiling_height_m - 0.03};
  light.radius_m = 0.2;
  light.lumens = lumens;
  light.is_ceiling_panel = true;
  home.lights.push_back(light);
}

// On the long walls, as people hang them along stairs.
void add_stair_pictures(HomeModel& home, std::size_t room, const StairHall& hall,
                        std::uint64_t seed, double out_from_m, double out_to_m, double rise_m) {
  RandomStream random(seed, {0x737461697273, room});
  for (const double side : {-1.0, 1.0}) {
    for (const double share : {0.15, 0.5, 0.85}) {
      WallPicture picture;
      picture.room = room;
      picture.width_m = 0.35 + 0.3 * random.uniform();
      picture.height_m = picture.width_m * (0.8 + 0.4 * random.uniform());
      const Vector2d place =
          hall.at(out_from_m + share * (out_to_m - out_from_m), side * kStairHall_m / 2);
      const double over_floor_m = side == hall.side ? rise_m * (1 - share) : 0.0;
      picture.center = {place.x(), place.y(), 1.55 + over_floor_m};
      picture.normal = -side * hall.aside();
      picture.seed = random.next();
      home.pictures.push_back(picture);
    }
  }
}

Staircase staircase_in(const StairHall& hall, const HomeModel& home, std::uint64_t seed) {
  RandomStream random(seed, {0x666c69676874});
  const double height_m = home.ceiling_height_m + kSlab_m;
  Staircase stairs;
  stairs.steps = static_cast<int>(std::lround(height_m / (0.168 + 0.022 * random.uniform())));
  stairs.rise_m = height_m / stairs.steps;
  stairs.going_m = kStep_m - 2 * stairs.rise_m;
  stairs.width_m = kFlight_m;
  stairs.up = -hall.out;
  // Who climbs towards the flat has `aside` to the right; the wall is on the flight's side.
  stairs.has_right_rail = hall.side < 0;
  stairs.has_left_rail = !stairs.has_right_rail;
  stairs.finish = {Material::kBoards, {172, 128, 84}, {120, 84, 52}, 0.14, random.next()};
  return stairs;
}

void move(HomeModel& home, const Vector3d& by) {
  const Vector2d floor = by.head<2>();
  for (Room& room : home.rooms) {
    room.interior.min += floor;
    room.interior.max += floor;
    for (auto* open : {&room.open_floor, &room.open_ceiling}) {
      if (!*open) continue;
      (*open)->min += floor;
      (*open)->max += floor;
    }
    room.floor_m += by.z();
    room.tiled_from_m += by.z();
    room.tiled_to_m += by.z();
  }
  const auto move_opening = [&](WallOpening& opening) {
    opening.center += floor;
    opening.floor_m += by.z();
  };
  for (Door& door : home.doors) move_opening(door.opening);
  for (Window& window : home.windows) move_opening(window.opening);
  for (WallPicture& picture : home.pictures) picture.center += by;
  for (Light& light : home.lights) light.position += by;
  for (PlacedObject& object : home.objects) object.world_from_object.translation += by;
}

// Names stay unique: a second hall is the "upper hall".
void add_storey(HomeModel upper, HomeModel& home) {
  const std::size_t rooms = home.rooms.size(), objects = home.objects.size();
  std::set<std::string> names;
  for (const Room& room : home.rooms) names.insert(room.name);
  for (Room& room : upper.rooms) {
    if (names.contains(room.name)) room.name = "upper " + room.name;
    room.storey = home.storeys.size();
    home.rooms.push_back(std::move(room));
  }
  for (Door& door : upper.doors) {
    door.room += rooms;
    if (door.other_room) *door.other_room += rooms;
    home.doors.push_back(door);
  }
  const auto take = [&](auto& from, auto& to) {
    for (auto& one : from) {
      one.room += rooms;
      to.push_back(std::move(one));
    }
  };
  for (Light& light : upper.lights) {
    if (light.object) *light.object += objects;
  }
  for (PlacedObject& object : upper.objects) {
    if (object.stands_on) *object.stands_on += objects;
  }
  take(upper.windows, home.windows);
  take(upper.pictures, home.pictures);
  take(upper.lights, home.lights);
  take(upper.objects, home.objects);
}

Rectangle extent_of(const HomeModel& home) {
  Rectangle extent = home.rooms.front().interior;
  for (const Room& room : home.rooms) {
    extent.min = extent.min.cwiseMin(room.interior.min);
    extent.max = extent.max.cwiseMax(room.interior.max);
  }
  return extent;
}

}  // namespace

Expected<HomeModel> generate_two_storeys(const HomeOptions& options,
                                         std::span<const FurnitureModel> models) {
  ROOMWISE_TRY(HomeModel home, plan_floor(options.seed, options.rooms));
  if (!has_front_door(home)) return fail("no wall of the hall is free for stairs");
  const Vector2d out = outward_of(front_door(home));
  ROOMWISE_TRY(HomeModel upper, plan_upper_storey(options.seed, out));
  upper.ceiling_height_m = home.ceiling_height_m;

  RandomStream random(options.seed, {0x73696465});
  StairHall hall{front_door(home).opening.center, out, random.uniform() < 0.5 ? -1.0 : 1.0,
                 home.wall_thickness_m, 0};
  Staircase stairs = staircase_in(hall, home, options.seed);
  hall.run_m = stairs.run_m();
  StairHall above = hall;
  above.wall = front_door(upper).opening.center;
  const double flight_aside_m = hall.side * (kStairHall_m - kFlight_m) / 2;
  stairs.foot = hall.at(kLanding_m + hall.run_m, flight_aside_m);
  const Door entrance = front_door(home);

  stairs.lower_room = home.rooms.size();
  open_to(hall, stairs.lower_room, home);
  open_to(above, upper.rooms.size(), upper);
  furnish(home, models);
  furnish(upper, models);

  Room below = stair_room("entrance", hall, options.seed, 101);
  below.open_ceiling = hall.part(kLanding_m, hall.length_m());
  home.rooms.push_back(std::move(below));
  add_panel(home, stairs.lower_room, hall.at(kLanding_m / 2, 0), 700);
  add_stair_pictures(home, stairs.lower_room, hall, options.seed, kLanding_m,
                     kLanding_m + hall.run_m, stairs.height_m());
  // The front door is at the far end, beside the first step.
  Door door = entrance;
  door.room = stairs.lower_room;
  door.opening.center =
      hall.at(hall.length_m() + home.wall_thickness_m / 2, -hall.side * kFlight_m / 2);
  home.doors.push_back(door);

  Room landing = stair_room("landing", above, options.seed, 101);
  landing.open_floor = above.part(kLanding_m, above.length_m());
  upper.rooms.push_back(std::move(landing));
  const std::size_t landing_room = upper.rooms.size() - 1;
  add_panel(upper, landing_room, above.at(kLanding_m / 2, 0), 900);
  add_panel(upper, landing_room, above.at(kLanding_m + hall.run_m / 2, 0), 1800);

  const Rectangle lower_extent = extent_of(home), upper_extent = extent_of(upper);
  // By whole cells of the free space, so that what was found free stays it.
  constexpr double kQuarter_m = 0.25;
  const double apart_m = lower_extent.max.x() + kBetweenPlans_m - upper_extent.min.x();
  const Vector2d beside(std::ceil(apart_m / kQuarter_m) * kQuarter_m, 0);
  move(upper, {beside.x(), beside.y(), 0});
  const Vector2d back = hall.wall - (above.wall + beside);
  stairs.upper_room = home.rooms.size() + landing_room;
  add_storey(std::move(upper), home);
  home.storeys.push_back({{back.x(), back.y(), stairs.height_m()}});
  home.stairs.push_back(stairs);
  name_objects(home);
  return apply_scenario(std::move(home), Scenario::kDay, options.seed, models);
}

HomeModel in_world(HomeModel plan) {
  for (std::size_t storey = 1; storey < plan.storeys.size(); ++storey) {
    const auto is_here = [&](std::size_t room) { return plan.rooms[room].storey == storey; };
    const Vector3d by = plan.storeys[storey].world_from_plan;
    HomeModel part;
    part.rooms.clear();
    // What belongs to the storey is taken out, moved, and put back where it was.
    const auto moved = [&](auto& all, auto HomeModel::*list, const auto& belongs) {
      for (std::size_t i = 0; i < all.size(); ++i) {
        if (!belongs(i)) continue;
        (part.*list).assign(1, all[i]);
        move(part, by);
        all[i] = (part.*list).front();
        (part.*list).clear();
      }
    };
    moved(plan.doors, &HomeModel::doors,
          [&](std::size_t i) { return is_here(plan.doors[i].room); });
    moved(plan.windows, &HomeModel::windows,
          [&](std::size_t i) { return is_here(plan.windows[i].room); });
    moved(plan.pictures, &HomeModel::pictures,
          [&](std::size_t i) { return is_here(plan.pictures[i].room); });
    moved(plan.lights, &HomeModel::lights,
          [&](std::size_t i) { return is_here(plan.lights[i].room); });
    moved(plan.objects, &HomeModel::objects,
          [&](std::size_t i) { return is_here(plan.objects[i].room); });
    moved(plan.rooms, &HomeModel::rooms, is_here);
  }
  return plan;
}

Vector2d place_below(const Staircase& stairs) {
  return stairs.foot - kStand_m * stairs.up;
}

Vector2d place_above(const HomeModel& plan, const Staircase& stairs) {
  const Storey& storey = plan.storeys[plan.rooms[stairs.upper_room].storey];
  const Vector2d world = stairs.foot + (stairs.run_m() + kStand_m) * stairs.up;
  return world - storey.world_from_plan.head<2>();
}

StairsWay way_over(const HomeModel& plan, const Staircase& stairs) {
  constexpr double kApart_m = 0.05;
  const Storey& storey = plan.storeys[plan.rooms[stairs.lower_room].storey];
  const double length_m = stairs.run_m() + 2 * kStand_m;
  const int parts = static_cast<int>(std::ceil(length_m / kApart_m));
  StairsWay way;
  for (int i = 0; i <= parts; ++i) {
    const double along_m = length_m * i / parts - kStand_m;  // from the first riser
    way.places.push_back(stairs.foot + along_m * stairs.up + storey.world_from_plan.head<2>());
    // A body rises with every step, most in its middle.
    const double steps =
        std::clamp(along_m / stairs.going_m + 0.5, 0.0, static_cast<double>(stairs.steps));
    const double whole = std::floor(steps), part = steps - whole;
    const double risen = part * part * (3 - 2 * part);
    way.floor_m.push_back(storey.world_from_plan.z() +
                          stairs.rise_m * (whole + (part + risen) / 2));
  }
  return way;
}

std::size_t room_at(const HomeModel& plan, const Vector2d& place_world, double floor_m) {
  std::size_t storey = 0;
  for (std::size_t i = 1; i < plan.storeys.size(); ++i) {
    const double half_m =
        (plan.storeys[i - 1].world_from_plan.z() + plan.storeys[i].world_from_plan.z()) / 2;
    if (floor_m > half_m) storey = i;
  }
  return room_at(plan, place_world - plan.storeys[storey].world_from_plan.head<2>());
}

}  // namespace roomwise::simulation
