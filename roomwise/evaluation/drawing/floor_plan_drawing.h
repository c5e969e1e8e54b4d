#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "roomwise/evaluation/drawing/svg.h"
#include "roomwise/image/image.h"

namespace roomwise::evaluation {

// The rooms of a home from above, in cells of a grid; places in cells from its lowest corner, y up.
struct FloorPlanView {
  struct Room {
    std::string name;
    double floor_m2 = 0;
    Eigen::Vector2d place = Eigen::Vector2d::Zero();  // of its name
  };
  struct Door {
    Eigen::Vector2d place = Eigen::Vector2d::Zero();
    bool is_walked = false;
  };
  double cell_m = 0;
  image::Image<std::int16_t> room_of_cell;  // index into rooms; -1: none. Row 0 is the lowest
  image::Image<std::uint8_t> is_floor;      // of the same size; not 0: free floor
  std::vector<Room> rooms;
  std::vector<Door> doors;
};

// Rooms in the colours that the map has them in (by their order), free floor light and what stands
// on it darker, with their names, none over another or over a door; doors as circles, filled where
// somebody walked through; a ruler of 1 m and a legend. Cells without a room stay empty. Where
// rooms are open to each other nothing but their colours meets.
[[nodiscard]] SvgDrawing draw_floor_plan(const FloorPlanView& view);

}  // namespace roomwise::evaluation
