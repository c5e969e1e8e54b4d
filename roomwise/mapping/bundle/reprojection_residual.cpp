#include "roomwise/mapping/bundle/reprojection_residual.h"

#include <limits>

namespace roomwise::mapping {
namespace {

using geometry::RigidTransform;

// The camera's motion from the middle row to the view's.
RigidTransform middle_from_row(const LandmarkView& view, const MovingCamera& camera,
                               const ViewModel& model) {
  if (model.readout_s == 0) return RigidTransform::identity();
  return RigidTransform::exp(view.row * model.readout_s * camera.velocity);
}

}  // namespace

Eigen::Vector3d reprojection_residual(const LandmarkView& view, const Eigen::Vector3d& point_world,
                                      const MovingCamera& camera, const ViewModel& model) {
  const RigidTransform& pose = camera.world_from_camera;
  Eigen::Vector3d point = pose.rotation.conjugate() * (point_world - pose.translation).eval();
  if (model.readout_s != 0) point = middle_from_row(view, camera, model).inverse() * point;
  if (!(point.z() > 0)) return Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  const Eigen::Vector2d pixel = model.camera.project_undistorted(point) - view.pixel;
  const motion::ResidualModel& residuals = model.residuals;
  const double disparity =
      view.depth_m > 0 ? residuals.focal_baseline_px_m * (1 / point.z() - 1 / view.depth_m) : 0.0;
  return {pixel.x() / residuals.pixel_sigma_px, pixel.y() / residuals.pixel_sigma_px,
          disparity / residuals.disparity_sigma_px};
}

ReprojectionJacobians reprojection_jacobians(const LandmarkView& view,
                                             const Eigen::Vector3d& point_world,
                                             const MovingCamera& camera, const ViewModel& model) {
  const RigidTransform& pose = camera.world_from_camera;
  const Eigen::Matrix3d middle_from_world = pose.rotation.conjugate().toRotationMatrix();
  const Eigen::Vector3d middle = middle_from_world * (point_world - pose.translation);
  const RigidTransform row_from_middle = middle_from_row(view, camera, model).inverse();
  const Eigen::Vector3d point = row_from_middle * middle;
  const motion::ResidualModel& residuals = model.residuals;
  const double inverse_z = 1 / point.z();
  Eigen::Matrix3d by_seen = Eigen::Matrix3d::Zero();  // by the point as the row's camera sees it
  by_seen(0, 0) = model.camera.fx * inverse_z / residuals.pixel_sigma_px;
  by_seen(0, 2) = -by_seen(0, 0) * point.x() * inverse_z;
  by_seen(1, 1) = model.camera.fy * inverse_z / residuals.pixel_sigma_px;
  by_seen(1, 2) = -by_seen(1, 1) * point.y() * inverse_z;
  if (view.depth_m > 0)
    by_seen(2, 2) =
        -residuals.focal_baseline_px_m * inverse_z * inverse_z / residuals.disparity_sigma_px;
  const Eigen::Matrix3d by_middle = by_seen * row_from_middle.rotation_matrix();
  ReprojectionJacobians jacobians;
  jacobians.by_point = by_middle * middle_from_world;
  // Turning the camera by r about its own axes moves the point by point x r.
  jacobians.by_pose << -jacobians.by_point, by_middle * geometry::skew_symmetric(middle);
  const Eigen::Vector3d speed =
      -(camera.velocity.head<3>().cross(point) + camera.velocity.tail<3>());
  jacobians.by_readout = view.row * (by_seen * speed);
  return jacobians;
}

}  // namespace roomwise::mapping
