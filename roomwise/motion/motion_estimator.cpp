#include "roomwise/motion/motion_estimator.h"

#include <algorithm>
#include <cmath>

#include "roomwise/motion/pnp_ransac.h"

namespace roomwise::motion {
namespace {

using geometry::PinholeCamera;
using geometry::RigidTransform;

// The matches that a pose explains, by pixel and, where measured, by depth.
std::vector<PointObservation> inliers_of(std::span<const PointObservation> observations,
                                         const RigidTransform& reference_from_current,
                                         const PinholeCamera& camera,
                                         const MotionOptions& options) {
  const RigidTransform current_from_reference = reference_from_current.inverse();
  std::vector<PointObservation> inliers;
  for (const PointObservation& observation : observations) {
    const Eigen::Vector3d error =
        residual(observation, current_from_reference, camera, options.residuals);
    const double pixel_error = error.head<2>().norm() * options.residuals.pixel_sigma_px;
    const double disparity_error = std::abs(error.z()) * options.residuals.disparity_sigma_px;
    if (pixel_error < options.inlier_px && disparity_error < options.inlier_px) {
      inliers.push_back(observation);
    }
  }
  return inliers;
}

}  // namespace

Expected<void> MotionOptions::validate() const {
  ROOMWISE_RETURN_IF_ERROR(matching.validate());
  if (min_inliers < 4) return fail("min_inliers = {} must be at least 4", min_inliers);
  if (min_matches < min_inliers) {
    return fail("min_matches = {} must not be below min_inliers = {}", min_matches, min_inliers);
  }
  if (min_features < 0) return fail("min_features = {} must not be negative", min_features);
  if (!(min_inlier_ratio >= 0 && min_inlier_ratio <= 1)) {
    return fail("min_inlier_ratio = {} must be between 0 and 1", min_inlier_ratio);
  }
  if (!(inlier_px > 0)) return fail("inlier_px = {} must be positive", inlier_px);
  if (max_iterations < 1) return fail("max_iterations = {} must be at least 1", max_iterations);
  if (!(confidence > 0 && confidence < 1))
    return fail("confidence = {} must be between 0 and 1", confidence);
  if (!(max_translation_m > 0) || !(max_rotation_rad > 0)) {
    return fail("max_translation_m = {} and max_rotation_rad = {} must be positive",
                max_translation_m, max_rotation_rad);
  }
  return {};
}

std::string_view to_string(MotionStatus status) {
  switch (status) {
    case MotionStatus::kFound:
      return "found";
    case MotionStatus::kTooFewFeatures:
      return "too few features";
    case MotionStatus::kTooFewMatches:
      return "too few matches";
    case MotionStatus::kTooFewInliers:
      return "too few inliers";
    case MotionStatus::kMotionTooLarge:
      return "motion too large";
    case MotionStatus::kContradicted:
      return "the depth images contradict the pose";
    case MotionStatus::kTooLittleOverlap:
      return "nothing in common";
    case MotionStatus::kContradictsPrior:
      return "the motion is not what was predicted";
  }
  return "unknown";
}

std::string MotionOutcome::describe() const {
  const std::string_view reason = to_string(status);
  switch (status) {
    case MotionStatus::kTooFewFeatures:
      return fmt::format("{} ({})", reason, features);
    case MotionStatus::kTooFewMatches:
      return fmt::format("{} ({})", reason, matches);
    case MotionStatus::kTooFewInliers:
      return fmt::format("{} ({} of {} matches)", reason, inliers, matches);
    case MotionStatus::kMotionTooLarge:
      return fmt::format("{} ({:.2f} m, {:.0f} degrees)", reason,
                         pose.reference_from_current.distance_m(),
                         pose.reference_from_current.angle_rad() * 180 / EIGEN_PI);
    case MotionStatus::kTooLittleOverlap:
      return std::string(reason);
    case MotionStatus::kFound:
    case MotionStatus::kContradicted:
    case MotionStatus::kContradictsPrior:
      return fmt::format("{} ({} inliers of {} matches)", reason, inliers, matches);
  }
  return "unknown";
}

std::vector<PointObservation> match_points(const MeasuredFeatures& reference,
                                           const MeasuredFeatures& current,
                                           const features::MatchOptions& options) {
  std::vector<PointObservation> observations;
  for (const features::Match& match :
       features::match_features(current.features, reference.features, options)) {
    if (!reference.has_point(match.train)) continue;
    observations.push_back({reference.points[match.train], current.pixels[match.query],
                            current.points[match.query].z()});
  }
  return observations;
}

MotionOutcome estimate_motion(std::span<const PointObservation> observations,
                              const PinholeCamera& camera, const MotionOptions& options,
                              RandomStream random) {
  MotionOutcome outcome;
  const auto stop = [&outcome](MotionStatus status) {
    outcome.status = status;
    return outcome;
  };
  outcome.matches = static_cast<int>(observations.size());
  if (outcome.matches < options.min_matches) return stop(MotionStatus::kTooFewMatches);

  PinholeCamera ideal = camera;  // observations are undistorted
  ideal.distortion = {};
  const PnpHypothesis hypothesis = solve_pnp_ransac(
      observations, [&](RandomStream&) { return ideal; }, 1, options, random);
  outcome.inliers = hypothesis.inliers;
  const auto enough = [&] {
    return outcome.inliers >= options.min_inliers &&
           outcome.inliers >= options.min_inlier_ratio * outcome.matches;
  };
  if (!enough()) return stop(MotionStatus::kTooFewInliers);

  // Refining moves the pose, which changes who is an inlier: a few rounds settle it.
  constexpr int kRounds = 4;
  outcome.pose.reference_from_current = hypothesis.current_from_reference.inverse();
  for (int round = 0; round < kRounds; ++round) {
    const auto inliers =
        inliers_of(observations, outcome.pose.reference_from_current, camera, options);
    outcome.inliers = static_cast<int>(inliers.size());
    if (!enough()) return stop(MotionStatus::kTooFewInliers);
    outcome.pose =
        refine_pose(inliers, outcome.pose.reference_from_current, camera, options.residuals);
  }
  const RigidTransform& motion = outcome.pose.reference_from_current;
  if (!motion.is_finite()) return stop(MotionStatus::kTooFewInliers);
  if (motion.distance_m() > options.max_translation_m ||
      motion.angle_rad() > options.max_rotation_rad) {
    return stop(MotionStatus::kMotionTooLarge);
  }
  return stop(MotionStatus::kFound);
}

MotionOutcome estimate_motion(const MeasuredFeatures& reference, const MeasuredFeatures& current,
                              const PinholeCamera& camera, const MotionOptions& options,
                              RandomStream random) {
  MotionOutcome outcome;
  const int features = static_cast<int>(std::min(reference.size(), current.size()));
  if (features >= options.min_features) {
    outcome = estimate_motion(match_points(reference, current, options.matching), camera, options,
                              random);
  }
  outcome.features = features;
  return outcome;
}

}  // namespace roomwise::motion
