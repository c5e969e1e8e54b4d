#pragma once

#include <Eigen/Core>

#include "roomwise/geometry/pinhole_camera.h"

namespace roomwise::motion {

// How far a measured point is from its prediction. Depth is compared as a structured-light camera
// measures it, as disparity d = focal_baseline_px_m / z, whose error is about the same at every
// distance.
struct ResidualModel {
  double pixel_sigma_px = 1.0;
  // Focal length times baseline of the depth camera, px m (a Kinect: about 525 px times 0.075 m).
  double focal_baseline_px_m = 40.0;
  double disparity_sigma_px = 1.0;
};

// (du, dv, dd) / sigma of a point in the camera's frame, m, that was measured at an undistorted
// pixel and at a depth (0: not measured; dd is 0, then). A point behind the camera gives an
// infinite residual.
[[nodiscard]] Eigen::Vector3d point_residual(const Eigen::Vector3d& point_camera,
                                             const Eigen::Vector2d& pixel, double depth_m,
                                             const geometry::PinholeCamera& camera,
                                             const ResidualModel& model);

// Its derivative by the point, which must lie in front of the camera.
[[nodiscard]] Eigen::Matrix3d point_residual_jacobian(const Eigen::Vector3d& point_camera,
                                                      bool has_depth,
                                                      const geometry::PinholeCamera& camera,
                                                      const ResidualModel& model);

}  // namespace roomwise::motion
