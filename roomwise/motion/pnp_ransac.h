#pragma once

#include <functional>
#include <limits>
#include <span>

#include "roomwise/base/random.h"
#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/motion/motion_estimator.h"

namespace roomwise::motion {

// A pose, with the camera it was found by, and how well it explains the matches: the sum over all
// of them of the squared distance, px^2, cut off at the inlier threshold (MSAC of Torr and
// Zisserman 2000), which tells equal counts of inliers apart.
struct PnpHypothesis {
  geometry::RigidTransform current_from_reference;
  geometry::PinholeCamera camera;
  double cost = std::numeric_limits<double>::infinity();
  int inliers = 0;
};

// The best of the poses of samples of three matches (P3P), each with the camera that is drawn for
// it; at least three observations. `right_camera` is how probable it is that a drawn camera is near
// enough to the true one, of which it follows how many samples are needed. Pixels are compared with
// what the camera sees, its distortion included.
[[nodiscard]] PnpHypothesis solve_pnp_ransac(
    std::span<const PointObservation> observations,
    const std::function<geometry::PinholeCamera(RandomStream&)>& sample_camera, double right_camera,
    const MotionOptions& options, RandomStream& random);

}  // namespace roomwise::motion
