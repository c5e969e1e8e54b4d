#include "roomwise/mapping/bundle/reprojection_residual.h"

namespace roomwise::mapping {
namespace {

using geometry::RigidTransform;

// The camera's motion from the middle row to the view's.
RigidTransform middle_from_row(const LandmarkView& view, const RollingShutterCamera& camera,
                               const ViewModel& model) {
  if (model.readout_s == 0) return RigidTransform::identity();
  return RigidTransform::exp(view.row * model.readout_s * camera.velocity);
}

}  // namespace

Eigen::Vector3d reprojection_residual(const LandmarkView& view, const Eigen::Vector3d& point_world,
                                      const RollingShutterCamera& camera, const ViewModel& model) {
  const RigidTransform& pose = camera.world_from_camera;
  Eigen::Vector3d point = pose.rotation.conjugate() * (point_world - pose.translation).eval();
  if (model.readout_s != 0) point = middle_from_row(view, camera, model).inverse() * point;
  return motion::point_residual(point, view.pixel, view.depth_m, model.camera, model.residuals);
}

ReprojectionJacobians reprojection_jacobians(const LandmarkView& view,
                                             const Eigen::Vector3d& point_world,
                                             const RollingShutterCamera& camera,
                                             const ViewModel& model) {
  const RigidTransform& pose = camera.world_from_camera;
  const Eigen::Matrix3d middle_from_world = pose.rotation.conjugate().toRotationMatrix();
  const Eigen::Vector3d middle = middle_from_world * (point_world - pose.translation);
  const RigidTransform row_from_middle = middle_from_row(view, camera, model).inverse();
  const Eigen::Vector3d point = row_from_middle * middle;
  const Eigen::Matrix3d d_seen =
      motion::point_residual_jacobian(point, view.depth_m > 0, model.camera, model.residuals);
  const Eigen::Matrix3d d_middle = d_seen * row_from_middle.rotation_matrix();
  ReprojectionJacobians jacobians;
  jacobians.d_point = d_middle * middle_from_world;
  // Turning the camera by r about its own axes moves the point by point x r.
  jacobians.d_pose << -jacobians.d_point, d_middle * geometry::skew_symmetric(middle);
  const Eigen::Vector3d speed =
      -(camera.velocity.head<3>().cross(point) + camera.velocity.tail<3>());
  jacobians.d_readout = view.row * (d_seen * speed);
  return jacobians;
}

}  // namespace roomwise::mapping
