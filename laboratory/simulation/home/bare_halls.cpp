#include "laboratory/simulation/home/bare_halls.h"

#include <algorithm>

namespace roomwise::simulation {
namespace {

bool is_hall(const HomeModel& home, std::size_t room) {
  return home.rooms[room].kind == RoomKind::kHall;
}

// Where each object is once those in halls are gone; nothing for those.
std::vector<std::optional<std::size_t>> places_left(const HomeModel& home) {
  std::vector<std::optional<std::size_t>> places;
  std::size_t next = 0;
  for (const PlacedObject& object : home.objects) {
    auto& place = places.emplace_back();
    if (!is_hall(home, object.room)) place = next++;
  }
  return places;
}

}  // namespace

HomeModel with_bare_halls(HomeModel home) {
  const auto places = places_left(home);
  const auto is_in_hall = [&](const auto& thing) { return is_hall(home, thing.room); };
  std::erase_if(home.pictures, is_in_hall);
  std::erase_if(home.lights, [&](const Light& light) { return light.object && is_in_hall(light); });
  std::erase_if(home.objects, is_in_hall);
  for (Light& light : home.lights) {
    if (light.object) light.object = places[*light.object];
  }
  for (PlacedObject& object : home.objects) {
    if (object.stands_on) object.stands_on = places[*object.stands_on];
  }
  for (Room& room : home.rooms) {
    if (room.kind != RoomKind::kHall) continue;
    room.floor = {Material::kPaint, {150, 145, 140}};
    room.walls = room.ceiling = {Material::kPaint, {235, 232, 226}};
    room.tiled_walls.reset();
  }
  return home;
}

}  // namespace roomwise::simulation
