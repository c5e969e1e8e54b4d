#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/base/timestamp.h"
#include "roomwise/geometry/rigid_transform.h"

namespace roomwise::recording {

struct StampedPose {
  TimestampNs timestamp_ns = 0;
  geometry::RigidTransform world_from_camera;
};
using Trajectory = std::vector<StampedPose>;  // in the order of time

// TUM's format: a line a pose, "timestamp tx ty tz qx qy qz qw", '#' begins a comment. Fails,
// naming the line, on missing or not-finite numbers, a quaternion of no length, times that do not
// increase, an empty file. A last line that was cut off while it was written is passed over.
[[nodiscard]] Expected<Trajectory> read_trajectory(const std::filesystem::path& path);
[[nodiscard]] std::string trajectory_text(std::span<const StampedPose> trajectory);
[[nodiscard]] std::string trajectory_line(const StampedPose& pose);  // with its line end
[[nodiscard]] Expected<void> write_trajectory(const std::filesystem::path& path,
                                              std::span<const StampedPose> trajectory);

}  // namespace roomwise::recording
