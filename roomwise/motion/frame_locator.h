#pragma once

#include <optional>

#include "roomwise/motion/frame_measurements.h"
#include "roomwise/motion/motion_estimator.h"
#include "roomwise/motion/view_alignment.h"

namespace roomwise::motion {

struct LocatorOptions {
  MotionOptions features;
  ViewAlignmentOptions views;
  // An alignment of views that starts from the prior is believed without features if its residual
  // is at most `sure_rms` (sigmas), it overlaps by `sure_overlap` and agrees there by
  // `sure_agreeing`, its worst determined direction is known to `sure_sigma` (m, half a rad), and
  // it lies no further from the prior than `sure_squared_mahalanobis` (e^T Omega e).
  double sure_rms = 1.3;
  double sure_overlap = 0.4;
  double sure_agreeing = 0.9;
  double sure_sigma = 0.005;
  double sure_squared_mahalanobis = 6;
  // A sure alignment is still compared with what features say if the camera moved this far, or was
  // predicted to: where a pattern repeats, views also fit a period off.
  double cross_check_min_translation_m = 0.12;
  double cross_check_min_rotation_rad = 0.14;
  double max_rms = 2.0;  // an alignment with a larger residual than this is none
  // Further from what was predicted than this (e^T Omega e) an alignment is not believed, nor are
  // fewer inliers among the features.
  double max_squared_mahalanobis = 20.0;
  int min_inliers_against_prior = 40;
  // Whether the prior is evidence of its own, on which the pose may rest where the views do not
  // tell. Not where it follows from what the map holds already, which would then count twice.
  bool rests_on_prior = true;
  // Whether a pose's information takes in that of the prior; not where that is kept besides.
  bool counts_prior = true;

  [[nodiscard]] Expected<void> validate() const;
};

// Where the current frame is relative to the reference, by all that both show. With a prior the
// views are aligned from there, and if that leaves no doubt, it is the answer; after a large motion
// they are also aligned from the features' pose, and the better fit counts. Else features say
// (estimate_motion); the views are aligned from their pose, and a pose at which the depth images
// contradict each other is none. Last, an alignment from the prior that fits is taken where there
// are too few features to say more. Frames without views are left to the features.
[[nodiscard]] MotionOutcome locate_frame(const FrameMeasurements& reference,
                                         const FrameMeasurements& current,
                                         const std::optional<PosePrior>& prior,
                                         const geometry::PinholeCamera& camera,
                                         const LocatorOptions& options, RandomStream random);

}  // namespace roomwise::motion
