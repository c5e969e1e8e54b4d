#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "roomwise/fusion/floor_grid.h"
#include "roomwise/image/image.h"
#include "roomwise/rooms/layout/named_walks.h"

// Whose floor each cell of a grid is.
namespace roomwise::rooms {

constexpr std::int16_t kNoRoom = -1;
constexpr std::int16_t kNamelessRoom = -2;  // of a room that somebody walked in and nobody named
// A door for a wheelchair is 0.9 m wide. What is wider is no door: there rooms meet halfway between
// the places that name them.
constexpr double kWidestDoor_m = 1.2;
constexpr double kMaxCells = 1e6;  // along a side: what is farther is a fault

// By cell of the grid: not 0 where floor is free, as the map shows it or because somebody walked
// there.
using FreeFloor = image::Image<std::uint8_t>;
[[nodiscard]] FreeFloor free_floor(const fusion::FloorGrid& grid,
                                   std::span<const WalkedPath> walks);

// From the middle of each free cell to the nearest that is not free, in cells; by row.
[[nodiscard]] std::vector<double> free_widths(const FreeFloor& floor);

// By cell: index of the room, kNamelessRoom or kNoRoom.
using RoomCells = image::Image<std::int16_t>;

// Rooms spread over the free floor from the places that are believed, over wide floor before
// narrow. Floor by a crossing, nearer than unsure_path_m, counts as narrower: of two narrow places,
// a door and what is left beside its leaf, the one by which the name changed is more likely the
// border. So do rooms without a name from nameless places, but for those from which a place that is
// believed is seen over free floor near by: they lie on that room's floor.
void spread_over_floor(const fusion::FloorGrid& grid, const FreeFloor& floor,
                       const NamedWalks& walks, double unsure_path_m, double farthest_seed_m,
                       RoomCells& room_of);

// What is not free goes to the room whose floor is nearest along the grid, so deep.
void take_furniture_in(const fusion::FloorGrid& grid, const FreeFloor& floor, double depth_m,
                       RoomCells& room_of);

}  // namespace roomwise::rooms
