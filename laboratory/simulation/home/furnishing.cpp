#include "laboratory/simulation/home/furnishing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "laboratory/simulation/home/kitchen_row.h"
#include "laboratory/simulation/home/room_furnisher.h"

namespace roomwise::simulation {
namespace {

bool is_lamp(const PlacedObject& object) {
  return object.kind == "lamp" || object.kind == "floor_lamp";
}

void add_ceiling_light(HomeModel& home, std::size_t room, RandomStream& random) {
  const Rectangle& interior = home.rooms[room].interior;
  const Eigen::Vector2d extent = size(interior);
  // One for a room, several along a hall.
  const int along = extent.x() > extent.y() ? 0 : 1;
  const int count = std::max(
      1, static_cast<int>(std::lround(extent[along] / std::max(3.5, 1.6 * extent[1 - along]))));
  const double temperature = 2700 + 1000 * random.uniform();
  for (int i = 0; i < count; ++i) {
    Eigen::Vector2d place = center(interior);
    place[along] = interior.min[along] + extent[along] * (i + 0.5) / count;
    Light light;
    light.room = room;
    light.position = {place.x(), place.y(), home.ceiling_height_m - 0.03};
    light.radius_m = 0.16 + 0.08 * random.uniform();
    light.lumens = 140 * area_m2(interior) / count + 400;
    light.color_temperature_k = temperature;
    light.is_ceiling_panel = true;
    home.lights.push_back(light);
  }
}

bool may_have_pictures(RoomKind kind) {
  return kind != RoomKind::kToilet;
}

// Whether a picture on a wall would hang over a window, a door, or behind something tall.
bool is_covered(const HomeModel& home, const Footprint& picture) {
  const auto hides = [&](const Footprint& other) { return bodies_overlap(picture, other, 0); };
  const double thickness = home.wall_thickness_m + 0.2;
  for (const Window& window : home.windows) {
    const WallOpening& hole = window.opening;
    Footprint light = as_footprint(hole_of(hole, thickness), 0, home.ceiling_height_m);
    if (hides(light.grown(window.has_curtains ? 0.35 : 0.12))) return true;
  }
  for (const Door& door : home.doors) {
    Footprint hole = as_footprint(hole_of(door.opening, thickness), 0, home.ceiling_height_m);
    if (hides(hole.grown(0.12))) return true;
    Door open = door;
    open.open_rad = 1.57;  // the wall behind the leaf
    const auto leaf = leaf_of(open, home.wall_thickness_m);
    if (leaf && hides(leaf->grown(0.12))) return true;
  }
  return std::ranges::any_of(home.objects, [&](const PlacedObject& object) {
    return hides(footprint_of(object).grown(0.05));
  });
}

void add_pictures(HomeModel& home, std::size_t room, RandomStream& random) {
  if (!may_have_pictures(home.rooms[room].kind)) return;
  const auto sides = sides_of(home.rooms[room].interior);
  const bool is_kitchen = home.rooms[room].kind == RoomKind::kKitchen;
  const auto wanted = static_cast<int>(random.index(is_kitchen ? 2 : 4)) + (is_kitchen ? 0 : 1);
  std::vector<Footprint> hung;
  constexpr int kTries = 40;
  for (int i = 0, found = 0; i < kTries && found < wanted; ++i) {
    const WallSide& side = sides[random.index(sides.size())];
    WallPicture picture;
    picture.room = room;
    picture.width_m = 0.3 + 0.6 * random.uniform();
    picture.height_m = picture.width_m * (0.6 + 0.8 * random.uniform());
    picture.seed = random.next();
    const double slack = side.length_m - picture.width_m - 0.2;
    const Eigen::Vector2d place =
        side.from + side.along * (0.1 + picture.width_m / 2 + slack * random.uniform());
    if (slack <= 0 || picture.height_m > 0.9) continue;
    picture.center = {place.x(), place.y(), 1.5 + 0.15 * random.uniform()};
    picture.normal = side.inward;
    Footprint footprint;
    footprint.center = place + side.inward * 0.03;
    footprint.half_size = {picture.width_m / 2, 0.03};
    footprint.yaw_rad = yaw_facing(side.inward);
    footprint.bottom_m = picture.center.z() - picture.height_m / 2;
    footprint.top_m = picture.center.z() + picture.height_m / 2;
    const bool overlaps = std::ranges::any_of(hung, [&](const Footprint& other) {
      return overlap_on_floor(footprint.grown(0.1), other, 0);
    });
    if (overlaps || is_covered(home, footprint)) continue;
    hung.push_back(footprint);
    home.pictures.push_back(picture);
    ++found;
  }
}

// One way to furnish a room; tells how many of its essentials found a place.
std::ptrdiff_t try_furnishing(HomeModel& home, std::size_t room,
                              std::span<const FurnitureModel> models, std::uint64_t attempt) {
  RoomFurnisher furnisher(home, room, models, RandomStream(home.seed, {0x6675726e, room, attempt}));
  const RoomKind kind = home.rooms[room].kind;
  if (kind == RoomKind::kKitchen) add_kitchen_row(furnisher);
  for (const FurnitureRule& rule : furniture_rules(kind)) furnisher.follow(rule);
  return std::ranges::count_if(essential_kinds(kind), [&](std::string_view essential) {
    return furnisher.count(essential) > 0;
  });
}

// Where a bed stands decides whether a wardrobe has room: tries again until all that the room needs
// is there, else takes the best of the tries.
void furnish_room(HomeModel& home, std::size_t room, std::span<const FurnitureModel> models) {
  constexpr std::uint64_t kMaxAttempts = 6;
  const auto before = static_cast<std::ptrdiff_t>(home.objects.size());
  const auto wanted = std::ranges::ssize(essential_kinds(home.rooms[room].kind));
  std::vector<PlacedObject> best;
  std::ptrdiff_t most = -1;
  for (std::uint64_t attempt = 0; attempt < kMaxAttempts && most < wanted; ++attempt) {
    const std::ptrdiff_t placed = try_furnishing(home, room, models, attempt);
    if (placed > most) {
      most = placed;
      best.assign(home.objects.begin() + before, home.objects.end());
    }
    home.objects.resize(static_cast<std::size_t>(before));
  }
  home.objects.insert(home.objects.end(), best.begin(), best.end());
}

}  // namespace

Light light_of_lamp(const HomeModel& home, std::size_t object) {
  const PlacedObject& lamp = home.objects[object];
  Light light;
  light.room = lamp.room;
  light.object = object;
  light.position = lamp.world_from_object * Eigen::Vector3d(0, 0, 0.75 * lamp.size_m.z());
  light.radius_m = 0.05;
  light.lumens = lamp.kind == "floor_lamp" ? 900 : 500;
  light.color_temperature_k = 2700;
  return light;
}

void name_objects(HomeModel& home) {
  std::map<std::string, int> total, named;
  for (const PlacedObject& object : home.objects) ++total[object.kind];
  for (PlacedObject& object : home.objects) {
    object.name = object.kind;
    std::ranges::replace(object.name, '_', ' ');
    if (total[object.kind] > 1)
      object.name = fmt::format("{} {}", object.name, ++named[object.kind]);
  }
}

void furnish(HomeModel& home, std::span<const FurnitureModel> models) {
  for (std::size_t room = 0; room < home.rooms.size(); ++room) {
    furnish_room(home, room, models);
    RandomStream random(home.seed, {0x6c69676874, room});
    add_ceiling_light(home, room, random);
    add_pictures(home, room, random);
  }
  for (std::size_t i = 0; i < home.objects.size(); ++i) {
    if (is_lamp(home.objects[i])) home.lights.push_back(light_of_lamp(home, i));
  }
  name_objects(home);
}

}  // namespace roomwise::simulation
