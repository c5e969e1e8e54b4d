#include "roomwise/fusion/floor_grid.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "roomwise/geometry/distance_transform.h"

namespace roomwise::fusion {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;

// What stands on one cell of the floor.
struct Column {
  int in_the_way = 0;   // vertices of the surface between step and person's height
  int floor = 0;        // vertices of the floor
  int empty = 0;        // cells seen empty between step and person's height
  int empty_low = 0;    // of these, the low ones
  int empty_below = 0;  // cells seen empty below the floor
};

// A single vertex may be a flaw of the map; what passes through a cell leaves several.
constexpr int kFewestVertices = 2;
constexpr int kFewestEmpty = 3;        // a reflection in a floor leaves less
constexpr double kFloorBelow_m = 0.1;  // the map may sag by so much

constexpr double kLow_m = 0.5;

// Of cells whose middles lie between two heights.
int cells_between(double low_m, double high_m, double cell_m) {
  return static_cast<int>(std::floor(high_m / cell_m - 0.5) - std::floor(low_m / cell_m - 0.5));
}

FloorCell state_of(const Column& column, const FloorGridOptions& options) {
  if (column.in_the_way >= kFewestVertices) return FloorCell::kOccupied;
  if (column.floor > 0) return FloorCell::kFree;
  if (column.empty_below >= kFewestEmpty) return FloorCell::kOccupied;
  const auto is_seen = [&](int empty, double up_to_m) {
    return empty >= options.min_empty * cells_between(options.step_m, up_to_m, options.cell_m);
  };
  const bool is_empty =
      is_seen(column.empty, options.person_height_m) && is_seen(column.empty_low, kLow_m);
  return is_empty ? FloorCell::kFree : FloorCell::kUnknown;
}

}  // namespace

Expected<void> FloorGridOptions::validate() const {
  if (!(cell_m >= 0.01 && cell_m <= 0.5)) return fail("cell_m is {}; expected 0.01 to 0.5", cell_m);
  if (!(step_m > 0)) return fail("step_m is {}; expected more than 0", step_m);
  if (!(person_height_m > kLow_m && person_height_m > step_m + cell_m)) {
    return fail("person_height_m is {}; expected more than {}, and than a step and a cell",
                person_height_m, kLow_m);
  }
  if (!(min_empty > 0 && min_empty <= 1)) {
    return fail("min_empty is {}; expected more than 0, at most 1", min_empty);
  }
  return {};
}

FloorGrid::FloorGrid(const Vector2d& origin_m, double cell_m, image::Image<FloorCell> cells)
    : origin_m_(origin_m), cell_m_(cell_m), cells_(std::move(cells)) {
  std::vector<double> squared;
  squared.reserve(cells_.pixels().size());
  for (const FloorCell cell : cells_.pixels()) {
    squared.push_back(cell == FloorCell::kOccupied ? 0.0 : geometry::kFarFromAll);
  }
  for (const double cells_apart : geometry::squared_distances(squared, columns(), rows())) {
    clearance_m_.push_back(
        cells_apart >= geometry::kFarFromAll
            ? std::numeric_limits<float>::infinity()
            : static_cast<float>(std::max(0.0, std::sqrt(cells_apart) - 0.5) * cell_m));
  }
}

std::optional<FloorGrid::Place> FloorGrid::cell_of(const Vector2d& point_plan) const {
  const Eigen::Array2d cell = ((point_plan - origin_m_) / cell_m_).array().floor();
  if (!(cell.x() >= 0 && cell.y() >= 0 && cell.x() < columns() && cell.y() < rows())) {
    return std::nullopt;
  }
  return Place{static_cast<int>(cell.x()), static_cast<int>(cell.y())};
}

FloorCell FloorGrid::at(const Vector2d& point_plan) const {
  const auto place = cell_of(point_plan);
  return place ? at(place->column, place->row) : FloorCell::kUnknown;
}

double FloorGrid::clearance_m(int column, int row) const {
  return static_cast<double>(
      clearance_m_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns()) +
                   static_cast<std::size_t>(column)]);
}

bool FloorGrid::fits(const Vector2d& point_plan, double radius_m) const {
  const auto place = cell_of(point_plan);
  return place && fits(place->column, place->row, radius_m);
}

std::size_t FloorGrid::count(FloorCell state) const {
  return static_cast<std::size_t>(std::ranges::count(cells_.pixels(), state));
}

Expected<FloorGrid> make_floor_grid(const TriangleMesh& mesh_gravity,
                                    std::span<const OccupancyCell> cells,
                                    const FloorGridOptions& options) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  const auto cell_of = [&](const Eigen::Vector3f& point) {
    return Vector2i((point.head<2>().cast<double>() / options.cell_m).array().floor().cast<int>());
  };
  Eigen::AlignedBox2i bounds;
  for (const Eigen::Vector3f& vertex : mesh_gravity.vertices) bounds.extend(cell_of(vertex));
  for (const OccupancyCell& cell : cells) bounds.extend(Vector2i(cell.cell.head<2>()));
  if (bounds.isEmpty()) return fail("nothing was seen: there is no floor to draw");

  image::Image<Column> columns(bounds.sizes().x() + 1, bounds.sizes().y() + 1);
  const auto column_at = [&](const Vector2i& cell) -> Column& {
    return columns.at(cell.x() - bounds.min().x(), cell.y() - bounds.min().y());
  };
  for (const Eigen::Vector3f& vertex : mesh_gravity.vertices) {
    const auto height_m = static_cast<double>(vertex.z());
    Column& column = column_at(cell_of(vertex));
    column.in_the_way += height_m > options.step_m && height_m < options.person_height_m ? 1 : 0;
    column.floor += height_m <= options.step_m && height_m > -kFloorBelow_m ? 1 : 0;
  }
  for (const OccupancyCell& cell : cells) {
    const double middle_m = (cell.cell.z() + 0.5) * options.cell_m;
    if (cell.is_occupied) continue;
    Column& column = column_at(cell.cell.head<2>());
    column.empty_below += middle_m < -kFloorBelow_m && middle_m > -kLow_m ? 1 : 0;
    if (middle_m <= options.step_m) continue;
    column.empty += middle_m <= options.person_height_m ? 1 : 0;
    column.empty_low += middle_m <= kLow_m ? 1 : 0;
  }

  image::Image<FloorCell> states(columns.width(), columns.height());
  for (int row = 0; row < columns.height(); ++row) {
    for (int column = 0; column < columns.width(); ++column) {
      states.at(column, row) = state_of(columns.at(column, row), options);
    }
  }
  return FloorGrid(bounds.min().cast<double>() * options.cell_m, options.cell_m, std::move(states));
}

}  // namespace roomwise::fusion
