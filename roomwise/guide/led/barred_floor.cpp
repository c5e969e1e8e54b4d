#include "roomwise/guide/led/barred_floor.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "roomwise/guide/places/clearance.h"
#include "roomwise/guide/places/obstacle.h"
#include "roomwise/guide/way/legs.h"
#include "roomwise/guide/words/wording.h"

namespace roomwise::guide {

using Eigen::Vector2d;

BarredFloor::BarredFloor(const fusion::FloorGrid* map, std::vector<BarredPlace> known)
    : map_(map), places_(map != nullptr ? std::move(known) : std::vector<BarredPlace>()) {
  mark_places();
}

void BarredFloor::bar_ahead(const Pose& pose, double radius_m, TimestampNs now_ns) {
  constexpr double kTouched_m = 0.35;
  places_.push_back(
      {pose.place_of({kTouched_m + radius_m, 0}), radius_m, after(now_ns, kBarred_s)});
  mark_places();
}

void BarredFloor::forget_old(TimestampNs now_ns) {
  if (std::erase_if(places_, [&](const BarredPlace& one) { return one.until_ns <= now_ns; }) > 0) {
    mark_places();
  }
}

void BarredFloor::clear() {
  places_.clear();
  mark_places();
}

void BarredFloor::bar_seen(std::span<const Vector2d> obstacles, TimestampNs now_ns) {
  constexpr double kSquare_m = 0.1;  // that each of them stands for
  const TimestampNs until_ns = after(now_ns, kBarred_s);
  std::vector<BarredPlace> unknown;
  for (const Vector2d& obstacle : obstacles) {
    for (BarredPlace& known : places_) {
      if ((known.middle_plan - obstacle).norm() < known.radius_m + kSquare_m) {
        known.until_ns = until_ns;
      }
    }
    if (is_on_map(obstacle, *grid())) continue;
    unknown.push_back({obstacle, kSquare_m / 2 + map_->cell_m() / 2, until_ns});
  }
  places_.insert(places_.end(), unknown.begin(), unknown.end());
  mark_places();
}

void BarredFloor::mark_places() {
  barred_.reset();
  if (places_.empty()) return;
  const fusion::FloorGrid& floor = *map_;
  image::Image<fusion::FloorCell> cells(floor.columns(), floor.rows(), fusion::FloorCell::kUnknown);
  for (int row = 0; row < floor.rows(); ++row) {
    for (int column = 0; column < floor.columns(); ++column) {
      cells.at(column, row) = floor.at(column, row);
    }
  }
  for (const auto& [middle, radius_m, until_ns] : places_) {
    const auto reach = static_cast<int>(std::ceil(radius_m / floor.cell_m()));
    const Eigen::Array2i cell =
        ((middle - floor.origin_m()) / floor.cell_m()).array().floor().cast<int>();
    for (int row = std::max(0, cell.y() - reach);
         row <= std::min(floor.rows() - 1, cell.y() + reach); ++row) {
      for (int column = std::max(0, cell.x() - reach);
           column <= std::min(floor.columns() - 1, cell.x() + reach); ++column) {
        if ((floor.cell_middle_m(column, row) - middle).norm() > radius_m) continue;
        cells.at(column, row) = fusion::FloorCell::kOccupied;
      }
    }
  }
  barred_ = fusion::FloorGrid(floor.origin_m(), floor.cell_m(), std::move(cells));
}

bool BarredFloor::was_barred_at(const Pose& pose) const {
  return tried_at_ && (*tried_at_ - pose.position_plan).norm() < kHand_m;
}

void BarredFloor::count_try(const Pose& pose) {
  tries_ = was_barred_at(pose) ? tries_ + 1 : 1;
  tried_at_ = pose.position_plan;
}

double BarredFloor::narrow_m_at(const Vector2d& here, double narrow_radius_m) const {
  return std::clamp(clearance_m(*grid(), here) - kPlaceError_m, 0.0, narrow_radius_m);
}

double BarredFloor::freer_side(const Pose& pose) const {
  constexpr double kAhead_m = 0.5;
  const auto room_m = [&](double side) {
    const double heading = pose.heading_rad + side * 30 * kDegree_rad;
    const Vector2d place =
        pose.position_plan + kAhead_m * Vector2d(std::cos(heading), std::sin(heading));
    double clear_m = 0;
    while (clear_m < kAhead_m && grid()->fits(place, clear_m)) clear_m += map_->cell_m();
    return clear_m;
  };
  return room_m(1) >= room_m(-1) ? 1 : -1;
}

}  // namespace roomwise::guide
