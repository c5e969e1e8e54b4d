#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "roomwise/recording/trajectory_file.h"

namespace roomwise::recording {

// odometry.txt of a TUM folder: where the device believed itself while it recorded.
struct Odometry {
  Trajectory poses;
  std::optional<Eigen::Vector3d> up;  // unit length; absent: its world may be tilted
};

// How sure a device says it is of a pose: of the position (x, y, z in its world, m) and of the
// rotation (about the same axes, rad), in this order.
using PoseCovariance = Eigen::Matrix<double, 6, 6>;

// A trajectory (read_trajectory()), in which a comment "# up X Y Z" may say which direction of its
// world is up. Fails as that does, and where that comment holds no direction.
[[nodiscard]] Expected<Odometry> read_odometry(const std::filesystem::path& path);
// The comment that says which way is up, with its line end.
[[nodiscard]] std::string up_line(const Eigen::Vector3d& up);
// `what`, one line, says for people of what it is.
[[nodiscard]] Expected<void> write_odometry(const std::filesystem::path& path,
                                            const Odometry& odometry, std::string_view what);

}  // namespace roomwise::recording
