#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "roomwise/home/home.h"
#include "roomwise/pipeline/mapping/home_floor.h"
#include "roomwise/rooms/layout/room_layout.h"

namespace roomwise::pipeline {

// A home's rooms on its floor; grid and layout lie on the plan of `frame`.
struct HomeLayout {
  fusion::GravityAlignedFrame frame;
  fusion::FloorGrid grid;
  rooms::RoomLayout layout;
};

// What people changed of where rooms lie, as rooms are called now. `frame`: of the home's map.
[[nodiscard]] Expected<std::vector<rooms::LayoutEdit>> layout_edits(
    const home::Home& home, const fusion::GravityAlignedFrame& frame);

// Where the camera was over the floor at each frame of a walk that the largest component of the map
// places.
struct FrameOnFloor {
  std::uint64_t index = 0;
  Eigen::Vector2d point_plan = Eigen::Vector2d::Zero();
};
[[nodiscard]] Expected<std::vector<FrameOnFloor>> frames_on_floor(
    const home::Home& home, home::RecordingId recording, const fusion::GravityAlignedFrame& frame);

// Spreads the rooms that the walks were named with over the floor of the home's map, and lays over
// it what people changed. Nothing where nobody walked on free floor in a named room.
[[nodiscard]] Expected<std::optional<rooms::RoomLayout>> find_room_layout(
    const home::Home& home, const fusion::GravityAlignedFrame& frame, const fusion::FloorGrid& grid,
    const rooms::RoomLayoutOptions& options = {});

// Spreads the rooms that the walks were named with over the floor of the home's map (see
// find_home_floor).
// Fails where the home has no map or no named rooms, where the map shows no floor, and when the
// user interrupts.
[[nodiscard]] Expected<HomeLayout> build_home_layout(const home::Home& home,
                                                     const rooms::RoomLayoutOptions& options,
                                                     RunContext& run);

// The same, and nothing where the home has no map or no named rooms, or its map does not show where
// they lie. Fails when the user interrupts.
[[nodiscard]] Expected<std::optional<HomeLayout>> find_home_layout(const home::Home& home,
                                                                   RunContext& run);

}  // namespace roomwise::pipeline
