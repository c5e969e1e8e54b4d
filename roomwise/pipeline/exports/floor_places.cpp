#include "roomwise/pipeline/exports/floor_places.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "roomwise/base/disjoint_sets.h"
#include "roomwise/guide/way/plan.h"

namespace roomwise::pipeline {
namespace {

constexpr double kPlace_m = 0.5;

// The cells where somebody fits who turns their shoulders, and what they belong to.
class PlaceCells {
 public:
  PlaceCells(const fusion::FloorGrid& grid, const rooms::RoomLayout* layout)
      : grid_(grid),
        layout_(layout),
        side_(std::max(1, static_cast<int>(std::lround(kPlace_m / grid.cell_m())))) {}

  [[nodiscard]] bool fits(int column, int row) const {
    return column < grid_.columns() && row < grid_.rows() &&
           grid_.fits(column, row, guide::PlanOptions{}.narrow_radius_m);
  }
  [[nodiscard]] std::optional<std::size_t> room(int column, int row) const {
    return layout_ == nullptr ? std::nullopt : layout_->room_of_cell(column, row);
  }
  // Both of them fit, and touch.
  [[nodiscard]] bool are_of_one_place(int column, int row, int next_column, int next_row) const {
    return column / side_ == next_column / side_ && row / side_ == next_row / side_ &&
           room(column, row) == room(next_column, next_row);
  }
  // take(column, row, next column, next row) for all that fit and touch by a side.
  template <typename Take>
  void for_each_pair(Take&& take) const {
    for (int row = 0; row < grid_.rows(); ++row) {
      for (int column = 0; column < grid_.columns(); ++column) {
        if (!fits(column, row)) continue;
        if (fits(column + 1, row)) take(column, row, column + 1, row);
        if (fits(column, row + 1)) take(column, row, column, row + 1);
      }
    }
  }
  [[nodiscard]] std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(grid_.columns()) +
           static_cast<std::size_t>(column);
  }

 private:
  const fusion::FloorGrid& grid_;
  const rooms::RoomLayout* layout_;
  int side_;  // cells
};

}  // namespace

FloorPlaces floor_places(const fusion::FloorGrid& grid, const rooms::RoomLayout* layout) {
  const PlaceCells cells(grid, layout);
  DisjointSets pieces(static_cast<std::size_t>(grid.rows()) *
                      static_cast<std::size_t>(grid.columns()));
  cells.for_each_pair([&](int column, int row, int next_column, int next_row) {
    if (cells.are_of_one_place(column, row, next_column, next_row))
      pieces.join(cells.index(column, row), cells.index(next_column, next_row));
  });
  FloorPlaces found;
  std::map<std::size_t, std::size_t> place_of;  // by the piece's first cell
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      if (!cells.fits(column, row)) continue;
      const auto [known, is_new] =
          place_of.try_emplace(pieces.find(cells.index(column, row)), found.places.size());
      if (is_new) found.places.emplace_back().room = cells.room(column, row);
      FloorPlace& place = found.places[known->second];
      const double clearance_m = grid.clearance_m(column, row);
      if (!is_new && clearance_m <= place.clearance_m) continue;
      place.clearance_m = clearance_m;
      place.middle_plan = grid.cell_middle_m(column, row);
    }
  }
  std::set<std::array<std::size_t, 2>> edges;
  cells.for_each_pair([&](int column, int row, int next_column, int next_row) {
    const std::size_t one = place_of.at(pieces.find(cells.index(column, row)));
    const std::size_t other = place_of.at(pieces.find(cells.index(next_column, next_row)));
    if (one != other) edges.insert({std::min(one, other), std::max(one, other)});
  });
  found.edges.assign(edges.begin(), edges.end());
  return found;
}

}  // namespace roomwise::pipeline
