#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "laboratory/simulation/home/home_geometry.h"
#include "laboratory/simulation/home/home_model.h"

namespace roomwise::simulation {

// Heights between which a person's body, with the camera in hand, can run into things.
constexpr double kBodyFromHeight = 0.1;
constexpr double kBodyToHeight = 1.9;

// A person's, seen from above, and what it takes to walk: the body sways, and the grid has cells.
constexpr double kPersonRadius = 0.25;
constexpr double kWalkingRadius = 0.30;

// The floor as a grid of 5 cm cells that know how far the nearest wall or thing is.
class FreeSpace {
 public:
  static constexpr double kCellSize = 0.05;

  // All of a home's floor, doors as they stand.
  [[nodiscard]] static FreeSpace of(const HomeModel& home);
  // What obstacles leave of floors (rectangles that may overlap).
  FreeSpace(std::span<const Rectangle> floors, std::span<const Footprint> obstacles);

  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] const Eigen::Vector2d& origin() const { return origin_; }
  [[nodiscard]] Eigen::Vector2d cell_center(int column, int row) const;
  // From the middle of the cell to the nearest wall or thing; 0 in it, and outside the grid. At
  // most half a cell too much, up to two cells too little (slantwise).
  [[nodiscard]] double clearance_m(int column, int row) const;
  [[nodiscard]] double clearance_m(const Eigen::Vector2d& point) const;

  // The cells (index = row * columns + column) with at least that clearance that can be reached
  // from a place; all false where the place itself lacks it.
  [[nodiscard]] std::vector<bool> reachable_from(const Eigen::Vector2d& place,
                                                 double radius_m) const;
  // The nearest place with that clearance, if there is one within a metre.
  [[nodiscard]] std::optional<Eigen::Vector2d> nearest_free(const Eigen::Vector2d& place,
                                                            double radius_m) const;
  // A short way (A*), cell by cell, that keeps away from things where there is room. Absent where
  // there is none.
  [[nodiscard]] std::optional<std::vector<Eigen::Vector2d>> path(const Eigen::Vector2d& from,
                                                                 const Eigen::Vector2d& to,
                                                                 double radius_m) const;

 private:
  [[nodiscard]] std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column);
  }
  [[nodiscard]] std::optional<std::size_t> cell_at(const Eigen::Vector2d& point) const;
  [[nodiscard]] Eigen::Vector2d cell_center(std::size_t cell) const;
  void measure_clearance(std::span<const Rectangle> floors, std::span<const Footprint> obstacles);

  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();  // the lower corner of cell (0, 0)
  int columns_ = 0, rows_ = 0;
  std::vector<float> clearance_m_;
};

}  // namespace roomwise::simulation
