#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "roomwise/recording/trajectory_file.h"

namespace roomwise::evaluation {

struct ErrorStatistics {
  double rmse = 0;
  double mean = 0;
  double median = 0;  // of an even number: the mean of the middle two
  double std = 0;     // about the mean, of the whole population
  double min = 0;
  double max = 0;

  // Of one value or more.
  [[nodiscard]] static ErrorStatistics of(std::vector<double> values);
};

// Where truth and estimate were at one time, both in the truth's frame, m.
struct PositionPair {
  TimestampNs timestamp_ns = 0;  // of the truth
  Eigen::Vector3d truth = Eigen::Vector3d::Zero();
  Eigen::Vector3d estimate = Eigen::Vector3d::Zero();  // aligned
};

struct AbsoluteTrajectoryError {
  std::vector<PositionPair> pairs;  // in the order of time
  geometry::RigidTransform truth_from_estimate;
  ErrorStatistics error_m;  // distances of the pairs
  // What the estimate's lengths must be multiplied by to fit best, and the RMSE with that done. A
  // depth camera measures lengths: error_m, without it, is the figure to report.
  double best_scale = 1;
  double scaled_rmse_m = 0;
};

// The absolute trajectory error of the TUM RGB-D benchmark (Sturm et al., "A Benchmark for the
// Evaluation of RGB-D SLAM Systems", 2012): poses are paired by time, the closest first, each used
// once; the estimate is moved onto the truth as a rigid body (Horn); what stays is the error. Fails
// where the two do not overlap in time, fewer than three pairs are found, or they lie on one line.
[[nodiscard]] Expected<AbsoluteTrajectoryError> absolute_trajectory_error(
    std::span<const recording::StampedPose> truth, std::span<const recording::StampedPose> estimate,
    double max_time_difference_s = 0.02);

struct RelativePoseErrorOptions {
  enum class Unit { kSeconds, kFrames };
  double delta = 1;              // how far apart the two poses are that are compared
  Unit unit = Unit::kSeconds;    // of delta; frames are those of the estimate that have a truth
  double delta_tolerance = 0.1;  // seconds: another distance in time is taken within this share
  double max_time_difference_s = 0.02;  // between an estimate and its truth

  [[nodiscard]] Expected<void> validate() const;
};

struct RelativePoseError {
  std::size_t count = 0;  // pairs of poses that were compared
  ErrorStatistics translation_m;
  ErrorStatistics rotation_deg;
};

// The relative pose error of the same benchmark: how far the estimated movement over `delta`
// differs from the true one. It needs no alignment and measures drift.
[[nodiscard]] Expected<RelativePoseError> relative_pose_error(
    std::span<const recording::StampedPose> truth, std::span<const recording::StampedPose> estimate,
    const RelativePoseErrorOptions& options = {});

}  // namespace roomwise::evaluation
