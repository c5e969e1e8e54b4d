#pragma once

#include <optional>

#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/motion/pose_refinement.h"
#include "roomwise/motion/rgbd_pyramid.h"
#include "roomwise/motion/view_agreement.h"

namespace roomwise::motion {

// What is expected of a pose before anything is measured, and how far it may be from that.
struct PosePrior {
  geometry::RigidTransform reference_from_current;
  // Inverse covariance, as RefinedPose::information.
  geometry::Matrix6d information = geometry::Matrix6d::Zero();

  // Another pose from which the search begins, for example if the camera did not move.
  std::optional<geometry::RigidTransform> other_start = std::nullopt;

  [[nodiscard]] static PosePrior around(const geometry::RigidTransform& reference_from_current,
                                        double translation_sigma_m, double rotation_sigma_rad);
};

// e^T Omega e of a pose against what was expected.
[[nodiscard]] double squared_mahalanobis(const geometry::RigidTransform& reference_from_current,
                                         const PosePrior& prior);

struct ViewAlignmentOptions {
  double gray_sigma = 6;  // grey levels, of noise, blur and changing light
  // What a pixel shows lies this far from where it should, px of the level: rows that were exposed
  // one after the other, colour and depth out of step, the coarse grid itself.
  double place_sigma_px = 0.5;
  // Depth noise is this much at 1 m and grows with the square of the distance, m.
  double depth_sigma_m = 0.004;
  double min_gray_slope = 4;  // per pixel; less is taken for noise
  double min_overlap = 0.2;
  double min_agreeing = 0.6;
  double max_seen_through = 0.2;

  [[nodiscard]] Expected<void> validate() const;
};

struct ViewAlignment {
  bool found = false;
  // Both starts led to different poses that fit about as well.
  bool is_ambiguous = false;
  RefinedPose pose;  // from the views and the prior; rms of the views, in sigmas
  geometry::Matrix6d measured_information = geometry::Matrix6d::Zero();  // of the views alone
  ViewAgreement agreement;
};

// Where the current view is relative to the reference, from all pixels: the distance of each point
// to the plane at its counterpart (iterative closest points by projection) and the difference of
// brightness (with the change of exposure taken out), minimised together from coarse to fine, held
// by the prior where the view does not tell. After Whelan et al., "Robust real-time visual odometry
// for dense RGB-D mapping", ICRA 2013.
[[nodiscard]] ViewAlignment align_views(const RgbdPyramid& reference, const RgbdPyramid& current,
                                        const PosePrior& prior,
                                        const ViewAlignmentOptions& options = {});

}  // namespace roomwise::motion
