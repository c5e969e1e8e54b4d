#pragma once

#include <string>
#include <vector>

#include "roomwise/fusion/floor_grid.h"
#include "roomwise/rooms/layout/room_layout.h"

namespace roomwise::guide::testing {

// Walls all around a floor of that many cells, and what is drawn on it. Cells of 0.1 m from (0, 0).
class Floor {
 public:
  static constexpr double kCell_m = 0.1;

  Floor(int columns, int rows) : cells_(columns, rows, fusion::FloorCell::kOccupied) {
    fill({1, 1}, {columns - 1, rows - 1}, fusion::FloorCell::kFree);
  }
  Floor& fill(const Eigen::Vector2i& from, const Eigen::Vector2i& to, fusion::FloorCell state) {
    for (int row = from.y(); row < to.y(); ++row) {
      for (int column = from.x(); column < to.x(); ++column) cells_.at(column, row) = state;
    }
    return *this;
  }
  [[nodiscard]] fusion::FloorGrid grid() const {
    return {Eigen::Vector2d::Zero(), kCell_m, cells_};
  }

 private:
  image::Image<fusion::FloorCell> cells_;
};

// Two rooms of 3.9 m by 3.9 m side by side, "bedroom" left of x = 4 and "kitchen" right of x = 4.1;
// a door of 0.9 m in the wall between, from y = 3 to y = 3.9.
inline Floor two_rooms() {
  return Floor(81, 40).fill({40, 1}, {41, 30}, fusion::FloorCell::kOccupied);
}
// Of rooms side by side, each up to a wall at every fourth metre, by a walk through their doors.
inline rooms::RoomLayout layout_along_x(const fusion::FloorGrid& grid,
                                        const std::vector<std::string>& names) {
  rooms::WalkedPath walk;
  for (double x = 0.6; x < 4.0 * static_cast<double>(names.size()) - 0.3; x += 0.25) {
    walk.push_back({{x, 3.45}, names.at(static_cast<std::size_t>(x / 4))});
  }
  const std::vector<rooms::WalkedPath> walks{walk};
  return rooms::RoomLayout::make(grid, walks).value();
}
inline rooms::RoomLayout layout_of_two_rooms(const fusion::FloorGrid& grid) {
  return layout_along_x(grid, {"bedroom", "kitchen"});
}
// A third room beyond such a door in the wall at x = 8.
inline Floor three_rooms() {
  return Floor(121, 40)
      .fill({40, 1}, {41, 30}, fusion::FloorCell::kOccupied)
      .fill({80, 1}, {81, 30}, fusion::FloorCell::kOccupied);
}

}  // namespace roomwise::guide::testing
