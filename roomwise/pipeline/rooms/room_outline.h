#pragma once

#include "roomwise/fusion/floor_grid.h"
#include "roomwise/fusion/storeys.h"
#include "roomwise/geometry/cell_outline.h"
#include "roomwise/rooms/layout/room_layout.h"

namespace roomwise::pipeline {

// What the map shows of a room (index into layout.rooms()): its cells that were seen or walked on,
// and those that these enclose, as the inside of a cupboard. The layout goes on beyond, through
// walls, to say where a thing belongs whose middle nobody saw.
[[nodiscard]] geometry::CellSet room_cells(const fusion::FloorGrid& grid,
                                           const rooms::RoomLayout& layout, std::size_t room);

// How the home is turned on every drawing of it from above (geometry::drawing_direction_rad), by
// what stands on its floor, in the gravity-aligned frame. 0 for one of several storeys, which lie
// side by side along x.
[[nodiscard]] double drawing_direction_rad(const fusion::FloorGrid& grid,
                                           const fusion::Storeys& storeys);

}  // namespace roomwise::pipeline
