#pragma once

#include <span>

#include "roomwise/motion/lens_estimate.h"
#include "roomwise/motion/motion_estimator.h"

namespace roomwise::motion {

// A pose found by a camera that nobody calibrated. The pose's information allows for what is not
// known of the lens; `lens` is what was known of it and what this picture tells, together.
struct LensMotion {
  MotionOutcome motion;
  IntrinsicsEstimate lens;
};

// PnP with RANSAC on matched points with an unknown focal length: each sample draws one from what
// is known, and pose, focal length and distortion are refined together on the inliers. Pixels of
// the observations are as the camera took them, their depth does not count; `width` and `height`
// are of the picture, px. As estimate_motion() otherwise, and the same where the lens is known
// well.
[[nodiscard]] LensMotion estimate_motion_and_lens(std::span<const PointObservation> observations,
                                                  int width, int height,
                                                  const IntrinsicsEstimate& lens,
                                                  const MotionOptions& options,
                                                  RandomStream random);

}  // namespace roomwise::motion
