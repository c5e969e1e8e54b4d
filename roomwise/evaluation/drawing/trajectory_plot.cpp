#include "roomwise/evaluation/drawing/trajectory_plot.h"

#include <algorithm>
#include <array>

#include "roomwise/evaluation/drawing/plot_axes.h"

namespace roomwise::evaluation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Which plane of the truth's frame the paper shows, and what its axes are called.
struct Plane {
  Eigen::Matrix<double, 2, 3> paper_from_truth;
  std::array<std::string, 2> labels;
};

Plane plane_across(const Vector3d& up) {
  Plane plane;
  // As near to the truth's own x (or, where that is nearly up, y) as a level axis can be.
  const Vector3d reference = std::abs(up.x()) < 0.9 ? Vector3d::UnitX() : Vector3d::UnitY();
  const Vector3d right = (reference - up.dot(reference) * up).normalized();
  plane.paper_from_truth << right.transpose(), up.cross(right).transpose();
  plane.labels = {"across [m]", "ahead [m]"};
  return plane;
}

Plane plane_of_largest_extent(std::span<const PositionPair> pairs) {
  Vector3d low = pairs.front().truth;
  Vector3d high = low;
  for (const PositionPair& pair : pairs) {
    low = low.cwiseMin(pair.truth);
    high = high.cwiseMax(pair.truth);
  }
  int shortest = 2;
  (high - low).minCoeff(&shortest);
  const std::array<int, 2> axes = {shortest == 0 ? 1 : 0, shortest == 2 ? 1 : 2};
  Plane plane;
  plane.paper_from_truth.setZero();
  for (int row = 0; row < 2; ++row) {
    const int axis = axes[static_cast<std::size_t>(row)];
    plane.paper_from_truth(row, axis) = 1;
    plane.labels[static_cast<std::size_t>(row)] = std::string(1, "xyz"[axis]) + " [m]";
  }
  return plane;
}

// Axes of one scale for both directions that hold all points with a margin. Tall trajectories get a
// tall plot, up to a square.
PlotAxes axes_around(std::span<const Vector2d> truth, std::span<const Vector2d> estimate,
                     double width_px) {
  Vector2d low = truth.front();
  Vector2d high = low;
  for (const auto points : {truth, estimate}) {
    for (const Vector2d& point : points) {
      low = low.cwiseMin(point);
      high = high.cwiseMax(point);
    }
  }
  constexpr double kMarginShare = 0.06;  // of the extent, on each side
  constexpr double kMinHeight = 0.5;     // of the width
  const Vector2d extent = (high - low).cwiseMax(1e-3) * (1 + 2 * kMarginShare);
  PlotAxes axes;
  axes.corner = {88, 92};
  const double plot_width = width_px - axes.corner.x() - 24;
  axes.size = {plot_width, plot_width * std::clamp(extent.y() / extent.x(), kMinHeight, 1.0)};
  const double metres_per_px = (extent.array() / axes.size.array()).maxCoeff();
  const Vector2d centre = (low + high) / 2;
  axes.low = centre - axes.size * metres_per_px / 2;
  axes.high = centre + axes.size * metres_per_px / 2;
  return axes;
}

void draw_legend(SvgDrawing& drawing, double x, double y) {
  for (const char* name : {"truth", "estimate", "difference"}) {
    drawing.line({x, y - 5}, {x + 32, y - 5}, fmt::format("class=\"{}\"", name));
    drawing.text({x + 40, y}, name, "");
    x += 140;
  }
}

}  // namespace

std::optional<Vector3d> axis_nearest_up(std::span<const recording::StampedPose> trajectory) {
  if (trajectory.empty()) return std::nullopt;
  Vector3d sum = Vector3d::Zero();
  for (const recording::StampedPose& pose : trajectory)
    sum -= pose.world_from_camera.rotation * Vector3d::UnitY();  // y is down in a picture
  int axis = 0;
  const double along = sum.cwiseAbs().maxCoeff(&axis);
  constexpr double kMinShare = 0.7;  // 45 degrees
  if (along < kMinShare * static_cast<double>(trajectory.size())) return std::nullopt;
  return Vector3d::Unit(axis) * (sum[axis] > 0 ? 1.0 : -1.0);
}

SvgDrawing plot_trajectory(const AbsoluteTrajectoryError& error,
                           const TrajectoryPlotOptions& options) {
  const Plane plane =
      options.up ? plane_across(options.up->normalized()) : plane_of_largest_extent(error.pairs);
  std::vector<Vector2d> truth;
  std::vector<Vector2d> estimate;
  for (const PositionPair& pair : error.pairs) {
    truth.emplace_back(plane.paper_from_truth * pair.truth);
    estimate.emplace_back(plane.paper_from_truth * pair.estimate);
  }
  const PlotAxes axes = axes_around(truth, estimate, options.width_px);

  const std::string figures =
      fmt::format("ATE {:.4f} m RMSE over {} poses", error.error_m.rmse, error.pairs.size());
  const std::string title =
      options.title.empty() ? figures : fmt::format("{}: {}", options.title, figures);
  SvgDrawing drawing = axes.paper(options.width_px, title, "Trajectory plot. ");
  draw_legend(drawing, axes.corner.x(), 70);
  axes.draw(drawing, plane.labels[0], plane.labels[1]);
  for (auto* const points : {&truth, &estimate}) {
    for (Vector2d& point : *points) point = axes.to_px(point);
  }
  for (std::size_t i = 0; i < truth.size(); ++i) {
    drawing.line(truth[i], estimate[i], "class=\"difference\"");
  }
  drawing.polyline(truth, "class=\"truth\"");
  drawing.polyline(estimate, "class=\"estimate\"");
  return drawing;
}

}  // namespace roomwise::evaluation
