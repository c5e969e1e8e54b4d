#include "roomwise/pipeline/mapping/walked_floor.h"

#include <algorithm>
#include <cmath>

namespace roomwise::pipeline {
namespace {

using Eigen::Vector2d;

constexpr double kHalfBody_m = 0.2;  // of who carried the camera, with the shoulders in
// From one key-frame to the next people go straight, if it is no more than so much.
constexpr double kStep_m = 1, kStep_s = 2;

// Over one floor, one right after the other.
bool is_step(const home::Keyframe& from, const home::Keyframe& to, const Vector2d& from_place,
             const Vector2d& to_place, const fusion::Storeys& storeys) {
  return from.recording == to.recording &&
         seconds_between(from.timestamp_ns, to.timestamp_ns) <= kStep_s &&
         (to_place - from_place).norm() <= kStep_m &&
         storeys.at_plan(from_place) == storeys.at_plan(to_place) &&
         storeys.stairs_at(from_place) == nullptr && storeys.stairs_at(to_place) == nullptr;
}

double distance_m(const Vector2d& from, const Vector2d& to, const Vector2d& point) {
  const Vector2d way = to - from;
  const double along = way.squaredNorm() > 0 ? (point - from).dot(way) / way.squaredNorm() : 0;
  return (from + std::clamp(along, 0.0, 1.0) * way - point).norm();
}

void walk(const Vector2d& from, const Vector2d& to, const fusion::FloorGrid& floor,
          image::Image<fusion::FloorCell>& cells) {
  const Vector2d margin = Vector2d::Constant(kHalfBody_m);
  const Vector2d lowest = (from.cwiseMin(to) - margin - floor.origin_m()) / floor.cell_m();
  const Vector2d highest = (from.cwiseMax(to) + margin - floor.origin_m()) / floor.cell_m();
  const auto cell = [](double value, int count) {
    return static_cast<int>(std::clamp(std::floor(value), 0.0, static_cast<double>(count - 1)));
  };
  for (int row = cell(lowest.y(), floor.rows()); row <= cell(highest.y(), floor.rows()); ++row) {
    for (int column = cell(lowest.x(), floor.columns());
         column <= cell(highest.x(), floor.columns()); ++column) {
      const bool is_walked = distance_m(from, to, floor.cell_middle_m(column, row)) <= kHalfBody_m;
      fusion::FloorCell& state = cells.at(column, row);
      if (is_walked && state == fusion::FloorCell::kUnknown) state = fusion::FloorCell::kFree;
    }
  }
}

}  // namespace

fusion::FloorGrid with_walked_ways(const fusion::FloorGrid& floor,
                                   const fusion::GravityAlignedFrame& frame,
                                   std::span<const home::Keyframe> keyframes) {
  image::Image<fusion::FloorCell> cells(floor.columns(), floor.rows());
  for (int row = 0; row < floor.rows(); ++row) {
    for (int column = 0; column < floor.columns(); ++column)
      cells.at(column, row) = floor.at(column, row);
  }
  const auto place_of = [&](const home::Keyframe& keyframe) -> Vector2d {
    return frame.on_plan(keyframe.pose.world_from_keyframe.translation).head<2>();
  };
  for (std::size_t i = 1; i < keyframes.size(); ++i) {
    const Vector2d from = place_of(keyframes[i - 1]), to = place_of(keyframes[i]);
    if (is_step(keyframes[i - 1], keyframes[i], from, to, frame.storeys)) {
      walk(from, to, floor, cells);
    }
  }
  return {floor.origin_m(), floor.cell_m(), std::move(cells)};
}

}  // namespace roomwise::pipeline
