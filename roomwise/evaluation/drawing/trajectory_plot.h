#pragma once

#include <optional>
#include <string>

#include "roomwise/evaluation/drawing/svg.h"
#include "roomwise/evaluation/errors/trajectory_error.h"

namespace roomwise::evaluation {

struct TrajectoryPlotOptions {
  std::string title = {};  // what was measured: the name of the recording
  // Unit vector of the truth's frame: the plot shows the plane across it, seen from its tip.
  // Absent: the two axes along which the truth extends farthest.
  std::optional<Eigen::Vector3d> up = std::nullopt;
  double width_px = 760;  // of the whole drawing; its height follows the trajectory's
};

// The axis of a trajectory's frame, with its sign, that is up for cameras held upright: the one
// nearest to the mean direction up in the pictures. Absent where none is clearly that.
[[nodiscard]] std::optional<Eigen::Vector3d> axis_nearest_up(
    std::span<const recording::StampedPose> trajectory);

// The plot of the TUM RGB-D benchmark: the truth in black, the estimate in blue, and in red the
// difference of each pair.
[[nodiscard]] SvgDrawing plot_trajectory(const AbsoluteTrajectoryError& error,
                                         const TrajectoryPlotOptions& options = {});

}  // namespace roomwise::evaluation
