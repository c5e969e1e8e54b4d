#include "roomwise/guide/led/in_the_way.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "roomwise/guide/places/clearance.h"

namespace roomwise::guide {
namespace {

using Eigen::Vector2d;

std::optional<InTheWay> in_the_way(const FollowedWay& way, const Pose& pose,
                                   std::span<const Vector2d> obstacles, const BarredFloor& floor) {
  const double to_end_m = way.to_end_m(pose);
  const Pose along{
      pose.position_plan,
      to_end_m > kAtEnd_m ? heading_to(pose.position_plan, way.leg().to) : way.leg().heading_rad(),
      pose.sigma_m};
  // Along what they stand at already they may go, not nearer.
  const double narrow_m =
      floor.narrow_m_at(pose.position_plan, way.options().plan.narrow_radius_m - kPlaceError_m);
  const WalkingCorridor line{
      .half_width_m = way.options().body_radius_m,
      .length_m = std::min(WalkingCorridor().length_m, to_end_m + kLegEnd_m)};
  const WalkingCorridor narrow{.half_width_m = narrow_m, .length_m = line.length_m};
  const WalkingCorridor facing{.half_width_m = narrow_m};
  const auto nearest = [&](const Pose& from, const WalkingCorridor& corridor,
                           bool on_map) -> std::optional<InTheWay> {
    std::vector<Vector2d> ahead;
    for (const Vector2d& obstacle : obstacles) {
      const Vector2d seen = from.ahead_left_of(obstacle);
      const bool counts =
          seen.x() > 0 && !way.is_goal(obstacle) && (on_map || !is_on_map(obstacle, *floor.grid()));
      if (counts) ahead.push_back(seen);
    }
    const auto obstacle = nearest_ahead(ahead, corridor);
    if (!obstacle) return std::nullopt;
    return InTheWay{*obstacle, from, on_map};
  };
  if (const auto unknown = nearest(along, line, false)) return unknown;
  const Vector2d checked_to = along.place_of({std::min(to_end_m, line.length_m), 0});
  if (!is_clear(*floor.grid(), pose.position_plan, checked_to, narrow_m)) {
    if (const auto known = nearest(along, narrow, true)) return known;
  }
  if (std::abs(way.bearing_error_rad(pose)) <= straight_enough_rad(to_end_m)) return std::nullopt;
  return nearest(pose, facing, true);
}

}  // namespace

bool is_newly_barred(const FollowedWay& way, const Pose& pose, std::span<const Vector2d> obstacles,
                     const BarredFloor& floor) {
  if (!way.has_legs() || floor.grid() == nullptr) return false;
  const auto found = in_the_way(way, pose, obstacles, floor);
  return found && !found->is_on_map;
}

ObstacleAhead::Side InTheWay::side_by(const Pose& pose) const {
  std::vector<Vector2d> ahead_left_m;
  for (const Vector2d& one : seen.all) {
    ahead_left_m.push_back(pose.ahead_left_of(from.place_of(one)));
  }
  return side_of(ahead_left_m);
}

std::optional<InTheWay> HazardWatch::look(const FollowedWay& way, const Pose& pose,
                                          std::span<const Vector2d> obstacles,
                                          const BarredFloor& floor, TimestampNs now_ns) {
  const Vector2d& here = pose.position_plan;
  if (known_stop_at_ && (*known_stop_at_ - here).norm() > kHand_m) known_stop_at_.reset();
  if (found_ns_ && seconds_between(*found_ns_, now_ns) < kSameHazard_s) return std::nullopt;
  const auto obstacle = in_the_way(way, pose, obstacles, floor);
  if (!obstacle || (obstacle->is_on_map && known_stop_at_)) return std::nullopt;
  // The first step is no hazard: before it one is stopped anyway.
  const bool is_step =
      way.goes_over_stairs_next() && obstacle->ahead_m() > way.to_end_m(pose) - kLegEnd_m;
  if (is_step) return std::nullopt;
  found_ns_ = now_ns;
  if (obstacle->is_on_map) known_stop_at_ = here;
  return obstacle;
}

}  // namespace roomwise::guide
