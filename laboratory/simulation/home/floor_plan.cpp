#include "laboratory/simulation/home/floor_plan.h"

#include <algorithm>
#include <array>
#include <string>

#include "laboratory/simulation/home/finishes.h"
#include "laboratory/simulation/home/floor_layout.h"
#include "laboratory/simulation/home/floor_openings.h"
#include "laboratory/simulation/home/home_geometry.h"
#include "roomwise/base/random.h"

namespace roomwise::simulation {
namespace {

constexpr std::size_t kMaxRooms = 8;
constexpr std::array<std::string_view, 3> kOrdinals{"", "second ", "third "};

// 3 to 8 rooms that people have together; small flats are rarer.
std::vector<RoomKind> choose_rooms(std::uint64_t seed) {
  RandomStream random(seed, {0x726f6f6d73});
  std::vector<RoomKind> rooms{RoomKind::kHall, RoomKind::kBedroom, RoomKind::kKitchen,
                              RoomKind::kToilet};
  constexpr std::array<std::size_t, 10> kCounts{3, 4, 5, 5, 6, 6, 7, 7, 8, 8};
  const std::size_t count = kCounts[random.index(kCounts.size())];
  if (count < rooms.size()) {
    rooms.erase(rooms.begin() + 1 + static_cast<std::ptrdiff_t>(random.index(3)));
    return rooms;
  }
  std::vector<RoomKind> more{RoomKind::kLivingRoom, RoomKind::kDiningRoom, RoomKind::kStudy,
                             RoomKind::kBedroom};
  std::shuffle(more.begin(), more.end(), random);
  // Few have a dining room and no living room.
  std::ranges::stable_partition(more, [](RoomKind kind) { return kind == RoomKind::kLivingRoom; });
  const std::size_t extra = count - rooms.size();
  rooms.insert(rooms.end(), more.begin(), more.begin() + static_cast<std::ptrdiff_t>(extra));
  return rooms;
}

std::string name_room(const std::vector<Room>& rooms, RoomKind kind) {
  const auto before = static_cast<std::size_t>(std::ranges::count(rooms, kind, &Room::kind));
  return std::string(kOrdinals[before]) + std::string(name_of(kind));
}

Expected<void> check_rooms(const std::vector<RoomKind>& rooms) {
  if (rooms.size() < 2) return fail("a home needs a room beside its hall; name more rooms");
  if (rooms.size() > kMaxRooms) {
    return fail("{} rooms with the hall are too many; name at most {}", rooms.size(), kMaxRooms);
  }
  for (const RoomKind kind : rooms) {
    const auto count = static_cast<std::size_t>(std::ranges::count(rooms, kind));
    const std::size_t most = kind == RoomKind::kHall ? 1 : kOrdinals.size();
    if (count > most) {
      return fail("{} rooms of kind {} are too many; name at most {}", count, name_of(kind), most);
    }
  }
  return {};
}

}  // namespace

Expected<HomeModel> plan_floor(std::uint64_t seed, std::vector<RoomKind> rooms) {
  if (rooms.empty()) rooms = choose_rooms(seed);
  if (std::ranges::count(rooms, RoomKind::kHall) == 0) rooms.push_back(RoomKind::kHall);
  ROOMWISE_RETURN_IF_ERROR(check_rooms(rooms));

  HomeModel home;
  home.seed = seed;
  RandomStream random(seed, {0x686f6d65});
  home.ceiling_height_m = 2.5 + 0.2 * random.uniform();
  const auto cells = lay_out(seed, rooms, home.wall_thickness_m);
  if (!cells) return fail("no flat was found for these rooms; name fewer, or other kinds");
  for (const LayoutCell& cell : *cells) {
    Room room;
    room.kind = cell.kind;
    room.name = name_room(home.rooms, cell.kind);
    room.interior = {cell.outline.min.array() + home.wall_thickness_m / 2,
                     cell.outline.max.array() - home.wall_thickness_m / 2};
    finish_room(seed, home.rooms.size(), room);
    home.rooms.push_back(std::move(room));
  }
  add_openings(seed, *cells, home);
  return home;
}

}  // namespace roomwise::simulation
