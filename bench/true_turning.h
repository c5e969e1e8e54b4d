#pragma once

#include <algorithm>
#include <cstddef>

#include "roomwise/base/expected.h"
#include "roomwise/base/timestamp.h"
#include "roomwise/recording/trajectory_file.h"

namespace roomwise {

// How a camera turned at one pose of its true trajectory, in its own frame, rad/s, by the poses
// beside it. Fails where there is no other, or all are of one time.
inline Expected<Eigen::Vector3d> true_turning_rad_s(const recording::Trajectory& truth,
                                                    std::size_t at) {
  const recording::StampedPose& from = truth[at - std::min<std::size_t>(at, 1)];
  const recording::StampedPose& to = truth[std::min(at + 1, truth.size() - 1)];
  const double seconds = static_cast<double>(to.timestamp_ns - from.timestamp_ns) * kSecondsPerNs;
  if (!(seconds > 0)) {
    return fail(
        "the true poses ({}) do not tell how the camera turned: that takes two at different "
        "times; give a recording with more of its truth",
        truth.size());
  }
  const Eigen::AngleAxisd turn((from.world_from_camera.inverse() * to.world_from_camera).rotation);
  return Eigen::Vector3d(turn.angle() / seconds * turn.axis());
}

}  // namespace roomwise
