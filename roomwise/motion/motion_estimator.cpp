#include "roomwise/motion/motion_estimator.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "roomwise/motion/perspective_three_point.h"

namespace roomwise::motion {
namespace {

using geometry::PinholeCamera;
using geometry::RigidTransform;

double reprojection_error2_px2(const PointObservation& observation,
                               const RigidTransform& current_from_reference,
                               const PinholeCamera& camera) {
  const Eigen::Vector3d point = current_from_reference * observation.point_reference;
  if (!(point.z() > 0)) return std::numeric_limits<double>::infinity();
  return (camera.project_undistorted(point) - observation.pixel_current).squaredNorm();
}

// A pose and how well it explains the matches: the sum over all of them of the squared distance,
// cut off at the inlier threshold (MSAC of Torr and Zisserman 2000), which tells equal counts of
// inliers apart.
struct Hypothesis {
  RigidTransform current_from_reference;
  double cost = std::numeric_limits<double>::infinity();
  int inliers = 0;
};

Hypothesis score(std::span<const PointObservation> observations,
                 const RigidTransform& current_from_reference, const PinholeCamera& camera,
                 double inlier_px, double cost_to_beat) {
  const double threshold2 = inlier_px * inlier_px;
  Hypothesis hypothesis{current_from_reference, 0, 0};
  for (const PointObservation& observation : observations) {
    const double error2 = reprojection_error2_px2(observation, current_from_reference, camera);
    hypothesis.cost += std::min(error2, threshold2);
    if (error2 < threshold2) ++hypothesis.inliers;
    if (hypothesis.cost >= cost_to_beat) break;
  }
  return hypothesis;
}

// How many samples of three make it improbable that none was free of outliers.
double samples_needed(double inlier_ratio, double confidence) {
  const double all_inliers = inlier_ratio * inlier_ratio * inlier_ratio;
  if (all_inliers >= 1) return 1;
  return std::log(1 - confidence) / std::log1p(-all_inliers);
}

std::array<std::size_t, 3> draw_three(RandomStream& random, std::size_t count) {
  std::array<std::size_t, 3> drawn{};
  do {
    for (std::size_t& index : drawn) index = random.index(count);
  } while (drawn[0] == drawn[1] || drawn[0] == drawn[2] || drawn[1] == drawn[2]);
  return drawn;
}

// Whether two points are about as far apart as the current frame measured them; true where it did
// not. Depth errors grow with the square of the distance.
bool has_same_edge_length(const PointObservation& a, const Eigen::Vector3d& ray_a,
                          const PointObservation& b, const Eigen::Vector3d& ray_b) {
  const double za = a.depth_current_m, zb = b.depth_current_m;
  if (za <= 0 || zb <= 0) return true;
  const double now_m = (ray_a * (za / ray_a.z()) - ray_b * (zb / ray_b.z())).norm();
  const double then_m = (a.point_reference - b.point_reference).norm();
  return std::abs(now_m - then_m) <= 0.03 + 0.015 * (za * za + zb * zb);
}

Hypothesis solve_pnp_ransac(std::span<const PointObservation> observations,
                            const PinholeCamera& camera, const MotionOptions& options,
                            RandomStream& random) {
  std::vector<Eigen::Vector3d> rays;
  rays.reserve(observations.size());
  for (const PointObservation& observation : observations) {
    rays.push_back(camera.unproject_undistorted(observation.pixel_current, 1.0).normalized());
  }
  Hypothesis best;
  double needed = options.max_iterations;
  for (int iteration = 0; iteration < needed; ++iteration) {
    const auto [i, j, k] = draw_three(random, observations.size());
    if (options.checks_edge_lengths &&
        !(has_same_edge_length(observations[i], rays[i], observations[j], rays[j]) &&
          has_same_edge_length(observations[i], rays[i], observations[k], rays[k]) &&
          has_same_edge_length(observations[j], rays[j], observations[k], rays[k]))) {
      continue;
    }
    const std::array points{observations[i].point_reference, observations[j].point_reference,
                            observations[k].point_reference};
    for (const RigidTransform& pose : solve_p3p(points, {rays[i], rays[j], rays[k]})) {
      const Hypothesis hypothesis = score(observations, pose, camera, options.inlier_px, best.cost);
      if (hypothesis.cost >= best.cost) continue;
      best = hypothesis;
      const double ratio = best.inliers / static_cast<double>(observations.size());
      needed = std::min<double>(options.max_iterations, samples_needed(ratio, options.confidence));
    }
  }
  return best;
}

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
  ROOMWISE_CHECK_OK(matching.validate());
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

  const Hypothesis hypothesis = solve_pnp_ransac(observations, camera, options, random);
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
