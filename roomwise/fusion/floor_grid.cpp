#include "roomwise/fusion/floor_grid.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

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

// The columns where anything was seen, in squares of them.
class Columns {
 public:
  explicit Columns(const FloorGridOptions& options)
      : options_(options),
        lowest_(static_cast<int>(std::floor(-kLow_m / options.cell_m)) - 1),
        words_(static_cast<std::size_t>(std::ceil(options.person_height_m / options.cell_m) + 1 -
                                        lowest_) /
                   kWordBits +
               1) {}

  // First all of the surface, then what is free: a cell that a surface passes is not.
  void add_vertex(const Eigen::Vector3d& vertex) {
    const auto cell_of = [&](const Eigen::Vector3d& point) {
      return Eigen::Vector3i((point.array() / options_.cell_m).floor().cast<int>());
    };
    // A vertex of a mesh has single precision, but not the surface of occupancy_cells().
    const Eigen::Vector3d rounded = vertex.cast<float>().cast<double>();
    const double height_m = rounded.z();
    {
      const auto [square, place] = at(cell_of(rounded).head<2>());
      Column& column = square->columns[place];
      column.in_the_way +=
          height_m > options_.step_m && height_m < options_.person_height_m ? 1 : 0;
      column.floor += height_m <= options_.step_m && height_m > -kFloorBelow_m ? 1 : 0;
    }
    const Eigen::Vector3i cell = cell_of(vertex);
    const auto [square, place] = at(cell.head<2>());
    if (std::uint64_t* const word = word_of(*square, place, cell.z())) *word |= bit_of(cell.z());
  }
  void add_free(const Eigen::Vector3i& cell) {
    const auto [square, place] = at(cell.head<2>());
    const std::uint64_t* const word = word_of(*square, place, cell.z());
    if (word == nullptr || (*word & bit_of(cell.z())) != 0) return;
    const double middle_m = (cell.z() + 0.5) * options_.cell_m;
    Column& column = square->columns[place];
    column.empty_below += middle_m < -kFloorBelow_m && middle_m > -kLow_m ? 1 : 0;
    if (middle_m <= options_.step_m) return;
    column.empty += middle_m <= options_.person_height_m ? 1 : 0;
    column.empty_low += middle_m <= kLow_m ? 1 : 0;
  }

  [[nodiscard]] const Eigen::AlignedBox2i& bounds() const { return bounds_; }
  // Those in the bounds that were met, and some that were not.
  template <typename Visit>
  void visit(const Visit& visit) const {
    for (const auto& [corner, square] : squares_) {
      for (int i = 0; i < kSide * kSide; ++i) {
        const Vector2i cell(kSide * corner.first + i % kSide, kSide * corner.second + i / kSide);
        if (bounds_.contains(cell)) visit(cell, square.columns[static_cast<std::size_t>(i)]);
      }
    }
  }

 private:
  static constexpr int kSide = 32;
  static constexpr int kWordBits = 64;
  struct Square {
    std::vector<Column> columns{std::size_t{kSide} * kSide};
    std::vector<std::uint64_t> occupied;  // a bit for each cell of a column from the lowest on
  };

  std::pair<Square*, std::size_t> at(const Vector2i& cell) {
    bounds_.extend(cell);
    static_assert(kSide == 1 << 5);
    const std::pair corner(cell.x() >> 5, cell.y() >> 5);  // arithmetic: rounds down
    if (last_ == nullptr || corner != last_corner_) {
      last_ = &squares_[corner];
      last_corner_ = corner;
      last_->occupied.resize(words_ * last_->columns.size());
    }
    return {last_,
            static_cast<std::size_t>((cell.y() & (kSide - 1)) * kSide + (cell.x() & (kSide - 1)))};
  }
  // Null where the height is of no interest.
  std::uint64_t* word_of(Square& square, std::size_t place, int z) const {
    const auto word = static_cast<std::size_t>(z - lowest_) / kWordBits;
    return z < lowest_ || word >= words_ ? nullptr : &square.occupied[place * words_ + word];
  }
  [[nodiscard]] std::uint64_t bit_of(int z) const {
    return std::uint64_t{1} << static_cast<unsigned>((z - lowest_) % kWordBits);
  }

  FloorGridOptions options_;
  int lowest_;
  std::size_t words_;
  std::map<std::pair<int, int>, Square> squares_;
  Square* last_ = nullptr;
  std::pair<int, int> last_corner_;
  Eigen::AlignedBox2i bounds_;
};

}  // namespace

Expected<void> FloorGridOptions::validate() const {
  if (!(cell_m >= 0.01 && cell_m <= 0.5)) return fail("cell_m is {}; expected 0.01 to 0.5", cell_m);
  if (!(step_m > 0)) return fail("step_m is {}; expected more than 0", step_m);
  if (!(person_height_m > kLow_m && person_height_m > step_m + cell_m)) {
    return fail("person_height_m is {}; expected more than {}, and than a step and a cell",
                person_height_m, kLow_m);
  }
  if (!(person_height_m <= 10)) {
    return fail("person_height_m is {}; expected at most 10", person_height_m);
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

Expected<FloorGrid> make_floor_grid(const PiecewiseMesh& mesh_world,
                                    const geometry::RigidTransform& gravity_from_world,
                                    const VisitFreeCells& visit_free_cells,
                                    const FloorGridOptions& options) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  Columns columns(options);
  ROOMWISE_RETURN_IF_ERROR(mesh_world.for_each([&](const MeshPiece& piece) {
    for (const Eigen::Vector3f& vertex : piece.own_vertices())
      columns.add_vertex(gravity_from_world * Eigen::Vector3d(vertex.cast<double>()));
  }));
  ROOMWISE_RETURN_IF_ERROR(visit_free_cells([&](std::span<const Eigen::Vector3i> cells) {
    for (const Eigen::Vector3i& cell : cells) columns.add_free(cell);
  }));
  const Eigen::AlignedBox2i& bounds = columns.bounds();
  if (bounds.isEmpty()) return fail("nothing was seen: there is no floor to draw");
  image::Image<FloorCell> states(bounds.sizes().x() + 1, bounds.sizes().y() + 1,
                                 FloorCell::kUnknown);
  columns.visit([&](const Vector2i& cell, const Column& column) {
    states.at(cell.x() - bounds.min().x(), cell.y() - bounds.min().y()) = state_of(column, options);
  });
  return FloorGrid(bounds.min().cast<double>() * options.cell_m, options.cell_m, std::move(states));
}

}  // namespace roomwise::fusion
