#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "roomwise/fusion/floor_grid.h"
#include "roomwise/fusion/storeys.h"
#include "roomwise/guide/way/route.h"

namespace roomwise::guide {

// Ways of a person over a floor grid: between cells where somebody of that radius fits; a metre
// with less than comfort_m around it counts as up to twice as long.
class FloorSearch {
 public:
  // The grid must outlive it.
  FloorSearch(const fusion::FloorGrid& grid, double person_radius_m, double comfort_m)
      : grid_(grid), person_radius_m_(person_radius_m), comfort_m_(comfort_m) {}

  // Ways may lead over these stairs, where somebody of that radius can stand at both ends. They
  // count as far as they are long along the floor and up.
  void lead_over(std::span<const fusion::Staircase> stairs);

  // The cell where a person fits that is nearest to a point, of those that `is_wanted`.
  [[nodiscard]] std::optional<Eigen::Vector2i> nearest_free(
      const Eigen::Vector2d& point, double farthest_m,
      const std::function<bool(const Eigen::Vector2d&)>& is_wanted) const;

  // Where a way may end: what ending in the middle of a cell counts in metres walked; nothing where
  // it must not end.
  using EndCost = std::function<std::optional<double>(const Eigen::Vector2d&)>;
  // The cells of the cheapest way from a cell to an end of it, both included; empty where none can
  // be reached. `end_cost` is asked once a cell at most, nearer cells first (Dijkstra 1959), and
  // must not be negative.
  [[nodiscard]] std::vector<Eigen::Vector2i> find(const Eigen::Vector2i& from,
                                                  const EndCost& end_cost) const;

  // Leaves out corners where the straight line is as far from everything as the way was, or
  // `enough_m` far.
  [[nodiscard]] Route straightened(const std::vector<Eigen::Vector2i>& way, double enough_m) const;

 private:
  [[nodiscard]] int index_of(const Eigen::Vector2i& cell) const {
    return cell.y() * grid_.columns() + cell.x();
  }
  [[nodiscard]] Eigen::Vector2i cell_of(int index) const {
    return {index % grid_.columns(), index / grid_.columns()};
  }
  [[nodiscard]] Eigen::Vector2d middle(const Eigen::Vector2i& cell) const {
    return grid_.cell_middle_m(cell.x(), cell.y());
  }
  [[nodiscard]] double clearance_m(const Eigen::Vector2i& cell) const {
    return grid_.clearance_m(cell.x(), cell.y());
  }
  [[nodiscard]] bool fits(const Eigen::Vector2i& cell) const {
    return grid_.fits(cell.x(), cell.y(), person_radius_m_);
  }
  template <typename Take>
  void for_each_step(const Eigen::Vector2i& cell, Take&& take) const;

  const fusion::FloorGrid& grid_;
  double person_radius_m_;
  double comfort_m_;
  struct Link {
    Eigen::Vector2i from, to;
    double length_m;
  };
  std::vector<Link> links_;
};

}  // namespace roomwise::guide
