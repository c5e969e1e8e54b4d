#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "laboratory/simulation/home/home_model.h"

namespace roomwise::simulation {

// Rooms as rectangles between the middle planes of their walls; together they tile the footprint.
struct LayoutCell {
  RoomKind kind = RoomKind::kHall;
  Rectangle outline;
};

// Absent where no tiling was found that gives every room a plausible size and a way in.
[[nodiscard]] std::optional<std::vector<LayoutCell>> lay_out(std::uint64_t seed,
                                                             std::span<const RoomKind> rooms,
                                                             double wall_thickness_m);

// The wall between two cells: where their outlines touch, without the thickness of crossing walls.
struct SharedWall {
  bool along_x = true;
  double across = 0;        // y of a wall along x, else x
  double from = 0, to = 0;  // along the wall

  [[nodiscard]] double length() const { return to - from; }
};
[[nodiscard]] std::optional<SharedWall> shared_wall(const Rectangle& a, const Rectangle& b,
                                                    double wall_thickness_m);

// Whether people leave out the door between two rooms.
[[nodiscard]] bool may_be_open_plan(RoomKind a, RoomKind b);

// Least length of a shared wall for a door with its frame, and for an open passage.
constexpr double kDoorWall = 1.15;
constexpr double kPassageWall = 1.5;

}  // namespace roomwise::simulation
