#include "laboratory/simulation/home/finishes.h"

#include <algorithm>
#include <span>

#include "roomwise/base/random.h"

namespace roomwise::simulation {
namespace {

struct Look {
  Material material;
  Rgb8 color, accent;
  double scale_m;
};

constexpr Look kPaints[] = {
    {Material::kPaint, {236, 232, 222}, {220, 214, 202}, 1.0},
    {Material::kPaint, {228, 217, 196}, {210, 198, 176}, 1.0},
    {Material::kPaint, {205, 216, 222}, {188, 200, 207}, 1.0},
    {Material::kPaint, {208, 217, 200}, {190, 200, 182}, 1.0},
    {Material::kPaint, {232, 205, 188}, {214, 186, 168}, 1.0},
    {Material::kPaint, {222, 216, 226}, {204, 198, 209}, 1.0},
    {Material::kPlaster, {230, 226, 217}, {214, 209, 198}, 0.6},
    {Material::kPlaster, {221, 207, 181}, {204, 189, 162}, 0.6},
};
constexpr Look kWallpapers[] = {
    {Material::kWallpaper, {226, 216, 198}, {196, 176, 148}, 0.53},
    {Material::kWallpaper, {206, 214, 216}, {160, 178, 188}, 0.40},
    {Material::kWallpaper, {222, 212, 214}, {184, 150, 158}, 0.32},
    {Material::kWallpaper, {214, 220, 204}, {160, 176, 146}, 0.45},
    {Material::kWallpaper, {236, 228, 208}, {206, 184, 128}, 0.26},
};
constexpr Look kWarmFloors[] = {
    {Material::kParquet, {166, 118, 72}, {128, 86, 50}, 0.09},
    {Material::kParquet, {190, 148, 100}, {156, 114, 72}, 0.07},
    {Material::kBoards, {150, 104, 64}, {112, 74, 44}, 0.14},
    {Material::kBoards, {198, 166, 124}, {166, 132, 92}, 0.18},
    {Material::kBoards, {112, 82, 60}, {80, 56, 40}, 0.16},
    {Material::kBoards, {176, 164, 148}, {144, 132, 116}, 0.19},
};
constexpr Look kCarpets[] = {
    {Material::kCarpet, {150, 138, 124}, {128, 116, 102}, 0.02},
    {Material::kCarpet, {112, 124, 142}, {94, 104, 122}, 0.02},
    {Material::kCarpet, {146, 96, 88}, {124, 78, 72}, 0.02},
};
constexpr Look kTiledFloors[] = {
    {Material::kTiles, {206, 198, 184}, {164, 156, 144}, 0.30},
    {Material::kTiles, {150, 152, 154}, {112, 114, 116}, 0.45},
    {Material::kTiles, {178, 128, 100}, {140, 112, 96}, 0.20},
    {Material::kTiles, {228, 226, 220}, {120, 122, 126}, 0.33},
    {Material::kStone, {176, 168, 154}, {142, 134, 122}, 0.60},
};
constexpr Look kWallTiles[] = {
    {Material::kTiles, {240, 240, 236}, {196, 196, 192}, 0.15},
    {Material::kTiles, {200, 218, 222}, {236, 238, 238}, 0.10},
    {Material::kTiles, {214, 206, 188}, {184, 176, 160}, 0.20},
    {Material::kTiles, {176, 200, 184}, {232, 234, 230}, 0.15},
    {Material::kTiles, {120, 140, 160}, {220, 224, 226}, 0.10},
};

std::uint8_t shifted(std::uint8_t value, double by) {
  return static_cast<std::uint8_t>(std::clamp(static_cast<double>(value) + by, 0.0, 255.0));
}

// One of the looks, a little lighter or darker, so that no two homes are the same.
Finish choose(RandomStream& random, std::span<const Look> looks) {
  const Look& look = looks[random.index(looks.size())];
  const double lighter = 16 * (random.uniform() - 0.5);
  const double warmer = 10 * (random.uniform() - 0.5);
  const auto changed = [&](Rgb8 color) {
    return Rgb8{shifted(color.r, lighter + warmer), shifted(color.g, lighter),
                shifted(color.b, lighter - warmer)};
  };
  return {look.material, changed(look.color), changed(look.accent), look.scale_m, random.next()};
}

Finish choose_floor(RandomStream& random, RoomKind kind) {
  switch (kind) {
    case RoomKind::kToilet:
      return choose(random, kTiledFloors);
    case RoomKind::kKitchen:
      return random.uniform() < 0.7 ? choose(random, kTiledFloors) : choose(random, kWarmFloors);
    case RoomKind::kHall:
      return random.uniform() < 0.4 ? choose(random, kTiledFloors) : choose(random, kWarmFloors);
    case RoomKind::kBedroom:
    case RoomKind::kStudy:
      return random.uniform() < 0.3 ? choose(random, kCarpets) : choose(random, kWarmFloors);
    case RoomKind::kLivingRoom:
    case RoomKind::kDiningRoom:
      break;
  }
  return choose(random, kWarmFloors);
}

bool may_be_papered(RoomKind kind) {
  return kind != RoomKind::kToilet && kind != RoomKind::kKitchen;
}

}  // namespace

void finish_room(std::uint64_t seed, std::size_t room_index, Room& room) {
  RandomStream random(seed, {0x66696e697368, room_index});
  room.floor = choose_floor(random, room.kind);
  room.walls = may_be_papered(room.kind) && random.uniform() < 0.35 ? choose(random, kWallpapers)
                                                                    : choose(random, kPaints);
  room.ceiling = {Material::kPaint, {243, 242, 238}, {236, 234, 229}, 1.0, random.next()};
  if (room.kind == RoomKind::kToilet) {
    room.tiled_walls = choose(random, kWallTiles);
    room.tiled_to_m = random.uniform() < 0.5 ? 2.0 : 1.5;
  } else if (room.kind == RoomKind::kKitchen) {
    room.tiled_walls = choose(random, kWallTiles);
    room.tiled_from_m = 0.85;
    room.tiled_to_m = 1.5;
  }
}

}  // namespace roomwise::simulation
