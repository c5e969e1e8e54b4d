#include "roomwise/pipeline/rooms/room_outline.h"

#include <algorithm>
#include <array>
#include <vector>

#include "roomwise/geometry/drawing_direction.h"

namespace roomwise::pipeline {

geometry::CellSet room_cells(const fusion::FloorGrid& grid, const rooms::RoomLayout& layout,
                             std::size_t room) {
  const auto index = [&](const Eigen::Vector2i& cell) {
    return static_cast<std::size_t>(cell.y()) * static_cast<std::size_t>(grid.columns()) +
           static_cast<std::size_t>(cell.x());
  };
  const auto is_of_room = [&](const Eigen::Vector2i& cell) {
    return cell.x() >= 0 && cell.y() >= 0 && cell.x() < grid.columns() && cell.y() < grid.rows() &&
           layout.room_of_cell(cell.x(), cell.y()) == room;
  };
  const auto is_unseen = [&](const Eigen::Vector2i& cell) {
    return is_of_room(cell) && !layout.is_floor(cell.x(), cell.y()) &&
           grid.at(cell.x(), cell.y()) == fusion::FloorCell::kUnknown;
  };
  geometry::CellSet cells{grid.columns(), grid.rows(), {}};
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      cells.has.push_back(is_of_room({column, row}));
    }
  }
  // From outside the room through what was not seen.
  std::vector<Eigen::Vector2i> open;
  const auto leave_out = [&](const Eigen::Vector2i& cell) {
    if (!is_unseen(cell) || !cells.has[index(cell)]) return;
    cells.has[index(cell)] = false;
    open.push_back(cell);
  };
  const std::array<Eigen::Vector2i, 4> steps{{Eigen::Vector2i(1, 0), Eigen::Vector2i(-1, 0),
                                              Eigen::Vector2i(0, 1), Eigen::Vector2i(0, -1)}};
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      const Eigen::Vector2i cell(column, row);
      if (std::ranges::any_of(steps, [&](const auto& step) { return !is_of_room(cell + step); })) {
        leave_out(cell);
      }
    }
  }
  while (!open.empty()) {
    const Eigen::Vector2i cell = open.back();
    open.pop_back();
    for (const Eigen::Vector2i& step : steps) leave_out(cell + step);
  }
  return cells;
}

double drawing_direction_rad(const fusion::FloorGrid& grid, const fusion::Storeys& storeys) {
  if (storeys.are_several()) return 0;
  std::vector<Eigen::Vector2d> standing;
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      if (grid.at(column, row) != fusion::FloorCell::kOccupied) continue;
      standing.push_back(grid.cell_middle_m(column, row));
    }
  }
  // The first camera stood over the origin.
  return geometry::drawing_direction_rad(standing, Eigen::Vector2d::Zero(), grid.cell_m());
}

}  // namespace roomwise::pipeline
