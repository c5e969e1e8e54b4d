#pragma once

#include <optional>
#include <span>
#include <vector>

#include "roomwise/motion/motion_estimator.h"

namespace roomwise::motion {

// Points of a frame, as its camera measured them, and where another frame of the walk sees them.
struct MatchedViews {
  std::vector<PointObservation> observations;
  geometry::RigidTransform reference_from_current;  // as the camera's focal length has it
};

// Which focal length the pictures themselves fit. Depth says how far a point is whatever the focal
// length; where the camera turns, pixels move by angle times focal length, while depth tells the
// angle.
struct FocalLengthFit {
  double ratio = 1;      // to the focal length that is given
  double log_sigma = 0;  // standard error of its logarithm, by how parts of the walk differ

  // The ratio surely lies between these: 99 of 100 times on either side.
  [[nodiscard]] double low() const;
  [[nodiscard]] double high() const;
  // Surely more than 5 % beside what is given. Less is not told from what depth cameras err in
  // other ways: by distance, by the time between colour and depth, by a shutter that rolls.
  [[nodiscard]] bool contradicts() const;
};

// Poses of all views and one focal length are fitted together; the error of the latter is that of
// ten parts of the walk (a sandwich estimate), so it holds whatever the noise of pixels and depth
// and however neighbouring views hang together. `views` in the order of the walk; undistorted.
// Nothing where there are too few of them, or where the error is larger than what is looked for, as
// of a camera that does not turn.
[[nodiscard]] std::optional<FocalLengthFit> fit_focal_length(std::vector<MatchedViews> views,
                                                             const geometry::PinholeCamera& camera,
                                                             const MotionOptions& options = {});

}  // namespace roomwise::motion
