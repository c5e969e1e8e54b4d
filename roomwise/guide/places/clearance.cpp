#include "roomwise/guide/places/clearance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace roomwise::guide {

using Eigen::Vector2d;

double clearance_m(const fusion::FloorGrid& floor, const Vector2d& place) {
  const Eigen::Array2d cell = ((place - floor.origin_m()) / floor.cell_m()).array().floor();
  const bool is_inside = (cell >= 0).all() && cell.x() < floor.columns() && cell.y() < floor.rows();
  return is_inside ? floor.clearance_m(static_cast<int>(cell.x()), static_cast<int>(cell.y()))
                   : std::numeric_limits<double>::infinity();
}

bool is_clear(const fusion::FloorGrid& floor, const Vector2d& from, const Vector2d& to,
              double min_m) {
  const auto steps = static_cast<int>(std::ceil((to - from).norm() / (floor.cell_m() / 2)));
  for (int i = 0; i <= steps; ++i) {
    if (!floor.fits(from + (to - from) * i / std::max(1, steps), min_m)) return false;
  }
  return true;
}

}  // namespace roomwise::guide
