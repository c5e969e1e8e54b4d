#include "laboratory/simulation/home/free_space.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

#include "roomwise/geometry/distance_transform.h"

namespace roomwise::simulation {
namespace {

constexpr double kFar = geometry::kFarFromAll;
// Clearance beyond which a way gets no better.
constexpr double kComfortable = 0.5;

Rectangle bounds_of(std::span<const Rectangle> floors) {
  Rectangle bounds = floors.front();
  for (const Rectangle& floor : floors) {
    bounds.min = bounds.min.cwiseMin(floor.min);
    bounds.max = bounds.max.cwiseMax(floor.max);
  }
  return bounds;
}

struct Step {
  int column, row;
  double length;
};
constexpr double kDiagonal = 1.4142135623730951;
constexpr std::array<Step, 8> kSteps{{{1, 0, 1},
                                      {-1, 0, 1},
                                      {0, 1, 1},
                                      {0, -1, 1},
                                      {1, 1, kDiagonal},
                                      {1, -1, kDiagonal},
                                      {-1, 1, kDiagonal},
                                      {-1, -1, kDiagonal}}};

}  // namespace

FreeSpace FreeSpace::of(const HomeModel& home) {
  return {floors_of(home), obstacles_of(home, kBodyFromHeight, kBodyToHeight)};
}

FreeSpace::FreeSpace(std::span<const Rectangle> floors, std::span<const Footprint> obstacles) {
  if (floors.empty()) return;
  const Rectangle bounds = bounds_of(floors);
  // One cell of wall on every side. Cells lie at the same places whatever part of a home is asked
  // for, so that a room by itself and the whole home agree on what is free.
  origin_ = ((bounds.min / kCellSize).array().floor() - 1) * kCellSize;
  const Eigen::Vector2d extent = (bounds.max - origin_) / kCellSize;
  columns_ = static_cast<int>(std::ceil(extent.x())) + 1;
  rows_ = static_cast<int>(std::ceil(extent.y())) + 1;
  measure_clearance(floors, obstacles);
}

void FreeSpace::measure_clearance(std::span<const Rectangle> floors,
                                  std::span<const Footprint> obstacles) {
  const std::size_t cells = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  std::vector<double> squared(cells, 0.0);
  const auto for_cells_in = [&](const Rectangle& area, const auto& body) {
    const Eigen::Vector2d low = (area.min - origin_) / kCellSize;
    const Eigen::Vector2d high = (area.max - origin_) / kCellSize;
    for (int row = std::max(0, static_cast<int>(low.y()));
         row <= std::min(rows_ - 1, static_cast<int>(high.y())); ++row) {
      for (int column = std::max(0, static_cast<int>(low.x()));
           column <= std::min(columns_ - 1, static_cast<int>(high.x())); ++column) {
        body(cell_center(column, row), squared[index(column, row)]);
      }
    }
  };
  for (const Rectangle& floor : floors) {
    for_cells_in(floor, [&](const Eigen::Vector2d& middle, double& cell) {
      if (contains(floor, middle)) cell = kFar;
    });
  }
  for (const Footprint& obstacle : obstacles) {
    // A leaf is thinner than a cell, and must still be a barrier.
    const Footprint solid = obstacle.grown(kCellSize / 2);
    for_cells_in(solid.bounds(), [&](const Eigen::Vector2d& middle, double& cell) {
      if (solid.contains(middle)) cell = 0;
    });
  }
  squared = geometry::squared_distances(std::move(squared), columns_, rows_);
  clearance_m_.reserve(cells);
  for (const double cells_apart_squared : squared) {
    // Between the middles of two cells less half a cell: to the other's near edge.
    const double cells_apart = std::sqrt(cells_apart_squared);
    clearance_m_.push_back(static_cast<float>(std::max(0.0, cells_apart - 0.5) * kCellSize));
  }
}

Eigen::Vector2d FreeSpace::cell_center(int column, int row) const {
  return origin_ + Eigen::Vector2d(column + 0.5, row + 0.5) * kCellSize;
}

Eigen::Vector2d FreeSpace::cell_center(std::size_t cell) const {
  const auto columns = static_cast<std::size_t>(columns_);
  return cell_center(static_cast<int>(cell % columns), static_cast<int>(cell / columns));
}

std::optional<std::size_t> FreeSpace::cell_at(const Eigen::Vector2d& point) const {
  const Eigen::Vector2d place = (point - origin_) / kCellSize;
  if (place.x() < 0 || place.y() < 0 || place.x() >= columns_ || place.y() >= rows_) {
    return std::nullopt;
  }
  return index(static_cast<int>(place.x()), static_cast<int>(place.y()));
}

double FreeSpace::clearance_m(int column, int row) const {
  if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return 0;
  return static_cast<double>(clearance_m_[index(column, row)]);
}

double FreeSpace::clearance_m(const Eigen::Vector2d& point) const {
  const auto cell = cell_at(point);
  return cell ? static_cast<double>(clearance_m_[*cell]) : 0.0;
}

std::vector<bool> FreeSpace::reachable_from(const Eigen::Vector2d& place, double radius_m) const {
  std::vector<bool> reached(clearance_m_.size());
  const auto start = cell_at(place);
  if (!start || static_cast<double>(clearance_m_[*start]) < radius_m) return reached;
  std::vector<std::size_t> open{*start};
  reached[*start] = true;
  while (!open.empty()) {
    const std::size_t cell = open.back();
    open.pop_back();
    const int column = static_cast<int>(cell % static_cast<std::size_t>(columns_));
    const int row = static_cast<int>(cell / static_cast<std::size_t>(columns_));
    for (std::size_t i = 0; i < 4; ++i) {  // the straight steps
      const int next_column = column + kSteps[i].column;
      const int next_row = row + kSteps[i].row;
      if (clearance_m(next_column, next_row) < radius_m) continue;
      const std::size_t next = index(next_column, next_row);
      if (reached[next]) continue;
      reached[next] = true;
      open.push_back(next);
    }
  }
  return reached;
}

std::optional<Eigen::Vector2d> FreeSpace::nearest_free(const Eigen::Vector2d& place,
                                                       double radius_m) const {
  constexpr double kFarthest = 1.0;
  std::optional<Eigen::Vector2d> nearest;
  double least = kFarthest;
  for (std::size_t cell = 0; cell < clearance_m_.size(); ++cell) {
    if (static_cast<double>(clearance_m_[cell]) < radius_m) continue;
    const Eigen::Vector2d middle = cell_center(cell);
    const double distance = (middle - place).norm();
    if (distance >= least) continue;
    least = distance;
    nearest = middle;
  }
  return nearest;
}

std::optional<std::vector<Eigen::Vector2d>> FreeSpace::path(const Eigen::Vector2d& from,
                                                            const Eigen::Vector2d& to,
                                                            double radius_m) const {
  const auto start = cell_at(from);
  const auto goal = cell_at(to);
  if (!start || !goal) return std::nullopt;
  constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  std::vector<double> cost(clearance_m_.size(), kFar);
  std::vector<std::size_t> came_from(clearance_m_.size(), kNone);
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  const Eigen::Vector2d target = cell_center(*goal);
  const auto to_go = [&](std::size_t cell) {
    return (cell_center(cell) - target).norm() / kCellSize;
  };
  cost[*start] = 0;
  open.emplace(to_go(*start), *start);
  while (!open.empty()) {
    const auto [estimate, cell] = open.top();
    open.pop();
    if (cell == *goal) break;
    if (estimate > cost[cell] + to_go(cell) + 1e-9) continue;  // an old entry
    const int column = static_cast<int>(cell % static_cast<std::size_t>(columns_));
    const int row = static_cast<int>(cell / static_cast<std::size_t>(columns_));
    for (const Step& step : kSteps) {
      const double clearance = clearance_m(column + step.column, row + step.row);
      if (clearance < radius_m) continue;
      const double discomfort = 1 + 4 * std::max(0.0, kComfortable - clearance);
      const std::size_t next = index(column + step.column, row + step.row);
      const double next_cost = cost[cell] + step.length * discomfort;
      if (next_cost >= cost[next]) continue;
      cost[next] = next_cost;
      came_from[next] = cell;
      open.emplace(next_cost + to_go(next), next);
    }
  }
  if (*goal != *start && came_from[*goal] == kNone) return std::nullopt;
  std::vector<Eigen::Vector2d> way;
  for (std::size_t cell = *goal; cell != kNone; cell = came_from[cell]) {
    way.push_back(cell_center(cell));
  }
  std::ranges::reverse(way);
  return way;
}

}  // namespace roomwise::simulation
