#include "roomwise/pipeline/edits/map_extent.h"

#include <Eigen/Geometry>

namespace roomwise::pipeline {

Expected<void> check_near_map(std::span<const home::Keyframe> keyframes,
                              const fusion::GravityAlignedFrame& frame,
                              const Eigen::Vector3d& point_plan) {
  constexpr double kSeen_m = 10;
  Eigen::AlignedBox3d walked;
  for (const home::Keyframe& keyframe : keyframes) {
    if (keyframe.pose.component == 0)
      walked.extend(frame.on_plan(keyframe.pose.world_from_keyframe.translation));
  }
  if (walked.isEmpty()) return {};
  const Eigen::Vector3d from = walked.min().array() - kSeen_m, to = walked.max().array() + kSeen_m;
  if (Eigen::AlignedBox3d(from, to).contains(point_plan)) return {};
  return fail(
      "the place ({:.6g}, {:.6g}), {:.6g} m above the floor, lies far outside the map; give x from "
      "{:.1f} to {:.1f} m, y from {:.1f} to {:.1f} m, a height from {:.1f} to {:.1f} m",
      point_plan.x(), point_plan.y(), point_plan.z(), from.x(), to.x(), from.y(), to.y(), from.z(),
      to.z());
}

}  // namespace roomwise::pipeline
