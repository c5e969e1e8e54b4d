#include "roomwise/motion/point_residual.h"

#include <limits>

namespace roomwise::motion {

Eigen::Vector3d point_residual(const Eigen::Vector3d& point_camera, const Eigen::Vector2d& pixel,
                               double depth_m, const geometry::PinholeCamera& camera,
                               const ResidualModel& model) {
  if (!(point_camera.z() > 0))
    return Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  const Eigen::Vector2d off = camera.project_undistorted(point_camera) - pixel;
  const double disparity =
      depth_m > 0 ? model.focal_baseline_px_m * (1 / point_camera.z() - 1 / depth_m) : 0.0;
  return {off.x() / model.pixel_sigma_px, off.y() / model.pixel_sigma_px,
          disparity / model.disparity_sigma_px};
}

Eigen::Matrix3d point_residual_jacobian(const Eigen::Vector3d& point_camera, bool has_depth,
                                        const geometry::PinholeCamera& camera,
                                        const ResidualModel& model) {
  const double inverse_z = 1 / point_camera.z();
  Eigen::Matrix3d d_point = Eigen::Matrix3d::Zero();
  d_point(0, 0) = camera.fx * inverse_z / model.pixel_sigma_px;
  d_point(0, 2) = -camera.fx * point_camera.x() * inverse_z * inverse_z / model.pixel_sigma_px;
  d_point(1, 1) = camera.fy * inverse_z / model.pixel_sigma_px;
  d_point(1, 2) = -camera.fy * point_camera.y() * inverse_z * inverse_z / model.pixel_sigma_px;
  if (has_depth)
    d_point(2, 2) = -model.focal_baseline_px_m * inverse_z * inverse_z / model.disparity_sigma_px;
  return d_point;
}

}  // namespace roomwise::motion
