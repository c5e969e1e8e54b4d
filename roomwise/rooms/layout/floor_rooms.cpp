#include "roomwise/rooms/layout/floor_rooms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <queue>

#include "roomwise/geometry/distance_transform.h"

namespace roomwise::rooms {
namespace {

using Eigen::Vector2d;
using fusion::FloorCell;
using fusion::FloorGrid;

// Who walked there took so much room; between two places farther apart than a step the walk is not
// known.
constexpr double kWalkerRadius_m = 0.25, kLongestStep_m = 1.0;

// Two places so near that see each other over free floor are in one room. No farther than a place
// deep in a room without a name is from one deep in the room next to it, straight through the door.
constexpr double kOneRoom_m = 1.5;

struct Cell {
  int column = 0, row = 0;
};
constexpr std::array kSides{Cell{1, 0}, Cell{-1, 0}, Cell{0, 1}, Cell{0, -1}};

// The nearest free cell within reach.
std::optional<Cell> free_cell_near(const FloorGrid& grid, const FreeFloor& floor,
                                   const Vector2d& point, double reach_m) {
  const Eigen::Array2d at = (point - grid.origin_m()) / grid.cell_m();
  const double reach = reach_m / grid.cell_m();
  if (!(at.abs() < kMaxCells).all()) return std::nullopt;
  const auto first = (at - reach).floor().cast<int>().max(0).eval();
  const int last_column =
      std::min(grid.columns() - 1, static_cast<int>(std::floor(at.x() + reach)));
  const int last_row = std::min(grid.rows() - 1, static_cast<int>(std::floor(at.y() + reach)));
  std::optional<Cell> best;
  double best_m = reach_m;
  for (int row = first.y(); row <= last_row; ++row) {
    for (int column = first.x(); column <= last_column; ++column) {
      if (floor.at(column, row) == 0) continue;
      const double distance_m = (grid.cell_middle_m(column, row) - point).norm();
      if (distance_m >= best_m) continue;
      best_m = distance_m;
      best = Cell{column, row};
    }
  }
  return best;
}

bool is_free_between(const FreeFloor& floor, Cell a, Cell b) {
  const Eigen::Array2d from(a.column, a.row), to(b.column, b.row);
  const int parts = 2 * static_cast<int>((to - from).abs().maxCoeff());
  for (int part = 1; part < parts; ++part) {
    const Eigen::Array2i at = (from + (to - from) * part / parts).round().cast<int>();
    if (floor.at(at.x(), at.y()) == 0) return false;
  }
  return true;
}

// Cells by level, the highest first and of one level those that came first.
class Flood {
 public:
  void push(double level, Cell cell) { queue_.push({level, next_--, cell}); }
  [[nodiscard]] bool empty() const { return queue_.empty(); }
  std::pair<double, Cell> pop() {
    const Entry entry = queue_.top();
    queue_.pop();
    return {entry.level, entry.cell};
  }

 private:
  struct Entry {
    double level;
    std::int64_t order;
    Cell cell;
    bool operator<(const Entry& other) const {
      return level != other.level ? level < other.level : order < other.order;
    }
  };
  std::priority_queue<Entry> queue_;
  std::int64_t next_ = 0;
};

}  // namespace

FreeFloor free_floor(const FloorGrid& grid, std::span<const WalkedPath> walks) {
  FreeFloor floor(grid.columns(), grid.rows(), 0);
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      floor.at(column, row) = grid.at(column, row) == FloorCell::kFree ? 1 : 0;
    }
  }
  const int reach = static_cast<int>(std::ceil(kWalkerRadius_m / grid.cell_m()));
  const auto stand_at = [&](const Vector2d& place) {
    const Eigen::Array2d at = ((place - grid.origin_m()) / grid.cell_m()).array().floor();
    if (!(at.abs() < kMaxCells).all()) return;
    const Cell middle{static_cast<int>(at.x()), static_cast<int>(at.y())};
    for (int row = middle.row - reach; row <= middle.row + reach; ++row) {
      for (int column = middle.column - reach; column <= middle.column + reach; ++column) {
        if (!floor.contains(column, row) || grid.at(column, row) != FloorCell::kUnknown) continue;
        if ((grid.cell_middle_m(column, row) - place).norm() > kWalkerRadius_m) continue;
        floor.at(column, row) = 1;
      }
    }
  };
  for (const WalkedPath& walk : walks) {
    for (std::size_t i = 0; i < walk.size(); ++i) {
      stand_at(walk[i].point_plan);
      if (i == 0) continue;
      const Vector2d step = walk[i].point_plan - walk[i - 1].point_plan;
      if (!(step.norm() <= kLongestStep_m)) continue;
      const int parts = static_cast<int>(std::ceil(step.norm() / grid.cell_m()));
      for (int part = 1; part < parts; ++part) {
        stand_at(walk[i - 1].point_plan + step * part / parts);
      }
    }
  }
  return floor;
}

std::vector<double> free_widths(const FreeFloor& floor) {
  // One cell around it: what lies outside is not free.
  const int columns = floor.width() + 2, rows = floor.height() + 2;
  std::vector<double> cells(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 0);
  for (int row = 0; row < floor.height(); ++row) {
    for (int column = 0; column < floor.width(); ++column) {
      if (floor.at(column, row) == 0) continue;
      cells[static_cast<std::size_t>((row + 1) * columns + column + 1)] = geometry::kFarFromAll;
    }
  }
  const std::vector<double> squared = geometry::squared_distances(std::move(cells), columns, rows);
  std::vector<double> widths;
  for (int row = 0; row < floor.height(); ++row) {
    for (int column = 0; column < floor.width(); ++column) {
      widths.push_back(
          std::sqrt(squared[static_cast<std::size_t>((row + 1) * columns + column + 1)]));
    }
  }
  return widths;
}

void spread_over_floor(const FloorGrid& grid, const FreeFloor& floor, const NamedWalks& walks,
                       double unsure_path_m, double farthest_seed_m, RoomCells& room_of) {
  constexpr double kLean = 0.35;  // m of width for a metre from the crossing
  const std::vector<double> widths = free_widths(floor);
  const auto width = [&](Cell cell) {
    double from_crossing_m = unsure_path_m;
    for (const Crossing& crossing : walks.crossings) {
      from_crossing_m = std::min(
          from_crossing_m, (grid.cell_middle_m(cell.column, cell.row) - crossing.place).norm());
    }
    const double free_m =
        grid.cell_m() *
        widths[static_cast<std::size_t>(cell.row) * static_cast<std::size_t>(grid.columns()) +
               static_cast<std::size_t>(cell.column)];
    return std::min(free_m, kWidestDoor_m / 2) + kLean * from_crossing_m;
  };
  Flood flood;
  const auto begin_at = [&](Cell cell, std::int16_t room) {
    if (room_of.at(cell.column, cell.row) != kNoRoom) return;
    room_of.at(cell.column, cell.row) = room;
    flood.push(width(cell), cell);
  };
  std::vector<Cell> named;
  for (const WalkEvidence& seed : believed(walks, unsure_path_m)) {
    const auto cell = free_cell_near(grid, floor, seed.place, farthest_seed_m);
    if (!cell) continue;
    begin_at(*cell, seed.room);
    named.push_back(*cell);
  }
  for (const Vector2d& place : walks.nameless) {
    const auto cell = free_cell_near(grid, floor, place, farthest_seed_m);
    if (!cell) continue;
    const bool is_in_named_room = std::ranges::any_of(named, [&](Cell other) {
      return std::hypot(other.column - cell->column, other.row - cell->row) * grid.cell_m() <=
                 kOneRoom_m &&
             is_free_between(floor, *cell, other);
    });
    if (!is_in_named_room) begin_at(*cell, kNamelessRoom);
  }
  while (!flood.empty()) {
    const auto [level, cell] = flood.pop();
    for (const Cell side : kSides) {
      const Cell next{cell.column + side.column, cell.row + side.row};
      if (!room_of.contains(next.column, next.row) ||
          room_of.at(next.column, next.row) != kNoRoom || floor.at(next.column, next.row) == 0) {
        continue;
      }
      room_of.at(next.column, next.row) = room_of.at(cell.column, cell.row);
      flood.push(std::min(level, width(next)), next);
    }
  }
}

void take_furniture_in(const FloorGrid& grid, const FreeFloor& floor, double depth_m,
                       RoomCells& room_of) {
  Flood flood;
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      if (room_of.at(column, row) != kNoRoom) flood.push(0, {column, row});
    }
  }
  while (!flood.empty()) {
    const auto [level, cell] = flood.pop();
    if (-level + grid.cell_m() > depth_m) continue;
    for (const Cell side : kSides) {
      const Cell next{cell.column + side.column, cell.row + side.row};
      if (!room_of.contains(next.column, next.row) ||
          room_of.at(next.column, next.row) != kNoRoom || floor.at(next.column, next.row) != 0) {
        continue;
      }
      room_of.at(next.column, next.row) = room_of.at(cell.column, cell.row);
      flood.push(level - grid.cell_m(), next);
    }
  }
}

}  // namespace roomwise::rooms
