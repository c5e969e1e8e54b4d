#include "roomwise/evaluation/errors/trajectory_error.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "roomwise/geometry/alignment.h"
#include "roomwise/recording/association.h"

namespace roomwise::evaluation {
namespace {

using geometry::RigidTransform;
using recording::Association;
using recording::StampedPose;
using Poses = std::span<const StampedPose>;

constexpr double kLongest = 1e9;  // s, far from the end of TimestampNs

TimestampNs to_ns(double seconds) {
  return std::llround(seconds / kSecondsPerNs);
}

std::vector<TimestampNs> times_of(Poses poses) {
  std::vector<TimestampNs> times;
  times.reserve(poses.size());
  for (const StampedPose& pose : poses) times.push_back(pose.timestamp_ns);
  return times;
}

std::string period_of(Poses poses) {
  return fmt::format("{} to {}", format_timestamp(poses.front().timestamp_ns),
                     format_timestamp(poses.back().timestamp_ns));
}

// first: the truth's place, second: the estimate's.
Expected<std::vector<Association>> pair_by_time(Poses truth, Poses estimate,
                                                double max_difference_s) {
  if (truth.empty()) return fail("the true trajectory holds no pose");
  if (estimate.empty()) return fail("the estimated trajectory holds no pose");
  if (!(max_difference_s > 0 && max_difference_s <= kLongest)) {
    return fail("max_time_difference_s is {}; expected more than 0, at most {}", max_difference_s,
                kLongest);
  }
  auto pairs = recording::associate(times_of(truth), times_of(estimate), to_ns(max_difference_s));
  if (pairs.empty()) {
    return fail("no pose of the estimate (times {}) lies within {} s of one of the truth ({})",
                period_of(estimate), max_difference_s, period_of(truth));
  }
  return pairs;
}

double root_mean_square(std::span<const double> values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

// Sets best_scale and scaled_rmse_m: the scale about the centre of the aligned estimate that
// minimises the sum of squared distances (Umeyama 1991, with the rotation that is there already).
void measure_scale(AbsoluteTrajectoryError& ate) {
  Eigen::Vector3d truth_mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d estimate_mean = Eigen::Vector3d::Zero();
  for (const PositionPair& pair : ate.pairs) {
    truth_mean += pair.truth;
    estimate_mean += pair.estimate;
  }
  truth_mean /= static_cast<double>(ate.pairs.size());
  estimate_mean /= static_cast<double>(ate.pairs.size());
  double together = 0;
  double estimate_alone = 0;
  for (const PositionPair& pair : ate.pairs) {
    together += (pair.truth - truth_mean).dot(pair.estimate - estimate_mean);
    estimate_alone += (pair.estimate - estimate_mean).squaredNorm();
  }
  ate.best_scale = together / estimate_alone;
  std::vector<double> errors;
  for (const PositionPair& pair : ate.pairs) {
    errors.push_back(
        ((pair.truth - truth_mean) - ate.best_scale * (pair.estimate - estimate_mean)).norm());
  }
  ate.scaled_rmse_m = root_mean_square(errors);
}

// The place of the paired estimate that follows the one at `start` by delta, if there is one.
std::optional<std::size_t> follower(std::span<const TimestampNs> times, std::size_t start,
                                    const RelativePoseErrorOptions& options) {
  if (options.unit == RelativePoseErrorOptions::Unit::kFrames) {
    const std::size_t end = start + static_cast<std::size_t>(std::llround(options.delta));
    return end < times.size() ? std::optional(end) : std::nullopt;
  }
  const TimestampNs wanted = times[start] + to_ns(options.delta);
  const auto after = std::lower_bound(times.begin(), times.end(), wanted);
  // Past the end of the estimate its last pose would stand for ever shorter distances.
  if (after == times.end()) return std::nullopt;
  const std::size_t later = static_cast<std::size_t>(after - times.begin());  // above start
  const std::size_t earlier = later - 1;
  const std::size_t nearest =
      earlier != start && wanted - times[earlier] < times[later] - wanted ? earlier : later;
  const TimestampNs tolerance = to_ns(options.delta * options.delta_tolerance);
  return std::abs(times[nearest] - wanted) <= tolerance ? std::optional(nearest) : std::nullopt;
}

}  // namespace

ErrorStatistics ErrorStatistics::of(std::vector<double> values) {
  ErrorStatistics result;
  const double count = static_cast<double>(values.size());
  result.rmse = root_mean_square(values);
  for (const double value : values) result.mean += value / count;
  double squares = 0;
  for (const double value : values) squares += (value - result.mean) * (value - result.mean);
  result.std = std::sqrt(squares / count);
  std::sort(values.begin(), values.end());
  result.min = values.front();
  result.max = values.back();
  const std::size_t middle = values.size() / 2;
  result.median =
      values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
  return result;
}

Expected<AbsoluteTrajectoryError> absolute_trajectory_error(Poses truth, Poses estimate,
                                                            double max_time_difference_s) {
  ROOMWISE_TRY(const auto pairs, pair_by_time(truth, estimate, max_time_difference_s));
  std::vector<Eigen::Vector3d> true_points;
  std::vector<Eigen::Vector3d> estimated_points;
  for (const Association& pair : pairs) {
    true_points.push_back(truth[pair.first].world_from_camera.translation);
    estimated_points.push_back(estimate[pair.second].world_from_camera.translation);
  }
  AbsoluteTrajectoryError result;
  ROOMWISE_TRY(result.truth_from_estimate, geometry::align_points(estimated_points, true_points));

  std::vector<double> errors;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    result.pairs.push_back({truth[pairs[i].first].timestamp_ns, true_points[i],
                            result.truth_from_estimate * estimated_points[i]});
    errors.push_back((result.pairs[i].truth - result.pairs[i].estimate).norm());
  }
  result.error_m = ErrorStatistics::of(std::move(errors));
  measure_scale(result);
  return result;
}

Expected<void> RelativePoseErrorOptions::validate() const {
  const double least = unit == Unit::kFrames ? 1 : kSecondsPerNs;
  if (!(delta >= least && delta <= kLongest)) {
    return fail("delta is {}; expected {} to {}", delta, least, kLongest);
  }
  if (unit == Unit::kFrames && delta != std::round(delta)) {
    return fail("delta is {} frames; expected a whole number", delta);
  }
  if (!(delta_tolerance > 0 && delta_tolerance < 1)) {
    return fail("delta_tolerance is {}; expected between 0 and 1", delta_tolerance);
  }
  return {};
}

Expected<RelativePoseError> relative_pose_error(Poses truth, Poses estimate,
                                                const RelativePoseErrorOptions& options) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  ROOMWISE_TRY(const auto pairs, pair_by_time(truth, estimate, options.max_time_difference_s));
  std::vector<TimestampNs> times;
  for (const Association& pair : pairs) times.push_back(estimate[pair.second].timestamp_ns);

  std::vector<double> translations_m;
  std::vector<double> rotations_deg;
  for (std::size_t start = 0; start < pairs.size(); ++start) {
    const auto end = follower(times, start, options);
    if (!end) continue;
    const auto movement = [](const StampedPose& from, const StampedPose& to) {
      return from.world_from_camera.inverse() * to.world_from_camera;
    };
    const RigidTransform true_movement =
        movement(truth[pairs[start].first], truth[pairs[*end].first]);
    const RigidTransform estimated_movement =
        movement(estimate[pairs[start].second], estimate[pairs[*end].second]);
    const RigidTransform error = true_movement.inverse() * estimated_movement;
    translations_m.push_back(error.distance_m());
    rotations_deg.push_back(error.angle_rad() * 180 / std::numbers::pi);
  }
  if (translations_m.empty()) {
    return fail("no two poses that have a truth are {} {} apart", options.delta,
                options.unit == RelativePoseErrorOptions::Unit::kFrames ? "frames" : "s");
  }
  RelativePoseError result;
  result.count = translations_m.size();
  result.translation_m = ErrorStatistics::of(std::move(translations_m));
  result.rotation_deg = ErrorStatistics::of(std::move(rotations_deg));
  return result;
}

}  // namespace roomwise::evaluation
