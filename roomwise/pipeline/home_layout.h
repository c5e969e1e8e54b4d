#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "roomwise/home/home.h"
#include "roomwise/pipeline/level_map.h"
#include "roomwise/rooms/room_layout.h"

namespace roomwise::pipeline {

// A home's rooms on its floor, in the level frame.
struct HomeLayout {
  fusion::LevelFrame frame;
  fusion::FloorGrid grid;
  rooms::RoomLayout layout;
};

// Spreads the rooms that the walks were named with over the floor of the home's map. Nothing where
// nobody walked on free floor in a named room.
[[nodiscard]] Expected<std::optional<rooms::RoomLayout>> find_room_layout(
    const home::Home& home, const fusion::LevelFrame& frame, const fusion::FloorGrid& grid,
    const rooms::RoomLayoutOptions& options = {});

// Fuses the map, finds its floor and spreads the rooms over it that the walks were named with.
// Fails where the home has no map or no named rooms, where the map shows no floor, and when the
// user interrupts.
[[nodiscard]] Expected<HomeLayout> build_home_layout(const home::Home& home,
                                                     const rooms::RoomLayoutOptions& options,
                                                     RunContext& run);

// The same, and nothing where the home has no map or no named rooms, or its map does not show where
// they lie. Fails when the user interrupts.
[[nodiscard]] Expected<std::optional<HomeLayout>> find_home_layout(const home::Home& home,
                                                                   RunContext& run);

// A home's layout against floorplan.json of the simulated recording that it was mapped from.
struct LayoutEvaluation {
  double floor_m2 = 0;        // of the map's free floor that lies in a room of the truth
  double right_floor_m2 = 0;  // of it that the layout gives the same name
  std::size_t doors = 0;      // of the truth that join two rooms that the walk named
  std::size_t found_doors = 0;
  std::size_t false_doorways = 0;     // of the layout, where no such door is
  std::vector<double> door_errors_m;  // of found doors, from middle to middle
  std::size_t things = 0,
              right_things = 0;  // objects whose middle lies in their room by the layout
};

// A door counts as found where a doorway of the same two rooms lies within a metre of it.
[[nodiscard]] Expected<LayoutEvaluation> evaluate_layout(const home::Home& home,
                                                         const std::filesystem::path& recording,
                                                         RunContext& run);

}  // namespace roomwise::pipeline
