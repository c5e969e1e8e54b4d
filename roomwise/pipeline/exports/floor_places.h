#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "roomwise/fusion/floor_grid.h"
#include "roomwise/rooms/layout/room_layout.h"

namespace roomwise::pipeline {

// A piece of floor, half a metre or less across, where somebody can stand: all of it hangs together
// and lies in one room, or in none that has a name.
struct FloorPlace {
  Eigen::Vector2d middle_plan = Eigen::Vector2d::Zero();  // where it is widest
  double clearance_m = 0;                                 // from there to what stands nearest
  std::optional<std::size_t> room;                        // index into layout.rooms()
};

// Pieces that touch are joined by an edge, so that edges lead between all places of one storey that
// people can reach from each other on its floor. Stairs join none. What is not known to be free is
// no place.
struct FloorPlaces {
  std::vector<FloorPlace> places;
  std::vector<std::array<std::size_t, 2>> edges;  // indices, the smaller first; each once
};

// `layout`: of this grid, or nullptr.
[[nodiscard]] FloorPlaces floor_places(const fusion::FloorGrid& grid,
                                       const rooms::RoomLayout* layout);

}  // namespace roomwise::pipeline
