#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/fusion/piecewise_mesh.h"
#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/image/image.h"

namespace roomwise::fusion {

enum class FloorCell : std::uint8_t { kUnknown, kFree, kOccupied };

struct FloorGridOptions {
  double cell_m = 0.05;
  double person_height_m = 1.9;  // what hangs higher is in nobody's way
  double step_m = 0.06;          // what lies lower is floor, a threshold or a carpet
  // Where the floor itself was not seen, the space above it must have been seen empty: that share
  // of it, and of its lowest half metre, where a box would stand.
  double min_empty = 0.6;

  [[nodiscard]] Expected<void> validate() const;
};

// A home's floor from above, in cells: where nothing is in a person's way. It lies on the plan, of
// one storey the gravity-aligned frame (see Storeys), metres. Cell (column, row) is the square from
// origin_m + cell_m * (column, row) to origin_m + cell_m * (column + 1, row + 1): columns go along
// x, rows along y. What lies outside the grid is unknown.
class FloorGrid {
 public:
  // cells.at(column, row).
  FloorGrid(const Eigen::Vector2d& origin_m, double cell_m, image::Image<FloorCell> cells);

  [[nodiscard]] int columns() const { return cells_.width(); }
  [[nodiscard]] int rows() const { return cells_.height(); }
  [[nodiscard]] double cell_m() const { return cell_m_; }
  [[nodiscard]] const Eigen::Vector2d& origin_m() const { return origin_m_; }
  [[nodiscard]] Eigen::Vector2d cell_middle_m(int column, int row) const {
    return origin_m_ + cell_m_ * Eigen::Vector2d(column + 0.5, row + 0.5);
  }

  [[nodiscard]] FloorCell at(int column, int row) const { return cells_.at(column, row); }
  [[nodiscard]] FloorCell at(const Eigen::Vector2d& point_plan) const;
  // From the middle of the cell to the nearest edge of an occupied one, give or take half a cell; 0
  // in it. Infinity where nothing is occupied.
  [[nodiscard]] double clearance_m(int column, int row) const;
  // Whether a person of that radius may stand with the middle there: on free floor, no occupied
  // cell nearer.
  [[nodiscard]] bool fits(int column, int row, double radius_m) const {
    return at(column, row) == FloorCell::kFree && clearance_m(column, row) >= radius_m;
  }
  [[nodiscard]] bool fits(const Eigen::Vector2d& point_plan, double radius_m) const;
  [[nodiscard]] std::size_t count(FloorCell state) const;
  [[nodiscard]] double area_m2(FloorCell state) const {
    return static_cast<double>(count(state)) * cell_m_ * cell_m_;
  }

 private:
  struct Place {
    int column, row;
  };
  [[nodiscard]] std::optional<Place> cell_of(const Eigen::Vector2d& point_plan) const;

  Eigen::Vector2d origin_m_;
  double cell_m_;
  image::Image<FloorCell> cells_;
  std::vector<float> clearance_m_;  // row * columns + column
};

// Calls back with all free cells, each once, some at a time (see fusion::visit_free_cells()).
using VisitFreeCells =
    std::function<Expected<void>(const std::function<void(std::span<const Eigen::Vector3i>)>&)>;

// Occupied: the surface passes between step and person's height; or the floor was not seen and the
// space below it was seen empty, so that one would fall. Free, otherwise: the floor was seen, or
// enough of the space above it was seen empty (see min_empty). The free cells are those of the
// grid's cell size in the gravity-aligned frame. Fails where there is neither surface nor cell, and
// where they cannot be read.
[[nodiscard]] Expected<FloorGrid> make_floor_grid(
    const PiecewiseMesh& mesh_world, const geometry::RigidTransform& gravity_from_world,
    const VisitFreeCells& visit_free_cells, const FloorGridOptions& options = {});

}  // namespace roomwise::fusion
