#pragma once

#include <span>
#include <string>
#include <vector>

#include "roomwise/base/random.h"
#include "roomwise/features/matcher.h"
#include "roomwise/motion/measured_features.h"
#include "roomwise/motion/pose_refinement.h"

namespace roomwise::motion {

struct MotionOptions {
  features::MatchOptions matching;
  int min_features = 20;
  int min_matches = 15;  // of points with depth
  int min_inliers = 12;
  double min_inlier_ratio = 0.15;  // of the matches
  double inlier_px = 3.0;          // a match further from its prediction is an outlier
  int max_iterations = 500;        // of RANSAC
  double confidence = 0.999;       // stops when a better pose is less probable than 1 minus this
  double max_translation_m = 3.0;  // between the two frames
  double max_rotation_rad = 1.6;
  // Samples of RANSAC whose points lie at other distances from each other in the current frame's
  // depth image than in the reference are passed over unsolved: finds poses among many more
  // outliers at the same cost.
  bool checks_edge_lengths = false;
  ResidualModel residuals;

  [[nodiscard]] Expected<void> validate() const;
};

enum class MotionStatus {
  kFound,
  kTooFewFeatures,
  kTooFewMatches,
  kTooFewInliers,
  kMotionTooLarge,
  kContradicted,      // by the depth images
  kTooLittleOverlap,  // views that do not overlap
  kContradictsPrior,  // too far from what was predicted for so few inliers
};
[[nodiscard]] std::string_view to_string(MotionStatus status);  // "found", "too few matches", ...

// Where the current frame is relative to the reference, or why that is not known.
struct MotionOutcome {
  MotionStatus status = MotionStatus::kTooFewFeatures;
  int features = 0;  // in the frame that has fewer
  int matches = 0;   // of reference points with depth
  int inliers = 0;
  RefinedPose pose;  // only meaningful when found
  // Found where it was expected, and the pictures only do not contradict: a bare wall.
  bool rests_on_prior = false;

  [[nodiscard]] bool found() const { return status == MotionStatus::kFound; }
  // "too few inliers (9 of 214 matches)".
  [[nodiscard]] std::string describe() const;
};

// The paper's PnP with RANSAC on matched points, refined on the inliers. The outcome's `features`
// are left at 0.
[[nodiscard]] MotionOutcome estimate_motion(std::span<const PointObservation> observations,
                                            const geometry::PinholeCamera& camera,
                                            const MotionOptions& options, RandomStream random);

// The matches between two frames whose reference point has depth.
[[nodiscard]] std::vector<PointObservation> match_points(const MeasuredFeatures& reference,
                                                         const MeasuredFeatures& current,
                                                         const features::MatchOptions& options);

// The paper's tracking: match the current frame's features with the reference's, solve PnP on the
// reference's 3-D points inside RANSAC, and refine the sum of squared distances on the inliers.
[[nodiscard]] MotionOutcome estimate_motion(const MeasuredFeatures& reference,
                                            const MeasuredFeatures& current,
                                            const geometry::PinholeCamera& camera,
                                            const MotionOptions& options, RandomStream random);

}  // namespace roomwise::motion
