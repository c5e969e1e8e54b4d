#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/motion/point_residual.h"

namespace roomwise::mapping {

// A landmark as one camera sees it.
struct LandmarkView {
  std::uint32_t camera = 0;                         // its place among the cameras
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  // undistorted
  double depth_m = 0;                               // 0: not measured
  // Where the pixel lies between the first row (-0.5) and the last (0.5) of the picture.
  double row = 0;
};

// A camera and how it moved while it took its picture.
struct RollingShutterCamera {
  geometry::RigidTransform world_from_camera;  // at the middle row
  // A twist in the camera's own frame: rotation in rad/s, then translation in m/s; zero where it is
  // not known.
  geometry::Vector6d velocity = geometry::Vector6d::Zero();
  std::uint32_t model = 0;  // by what its views are predicted: its place among the models
};

// What all views by one device have in common.
struct ViewModel {
  geometry::PinholeCamera camera;  // its lens is taken out of the views already
  motion::ResidualModel residuals;
  // A rolling shutter exposes the last row so much later than the first, s; 0: all at once.
  double readout_s = 0;
};

// motion::point_residual() of a view from where the camera stood when it exposed that row.
[[nodiscard]] Eigen::Vector3d reprojection_residual(const LandmarkView& view,
                                                    const Eigen::Vector3d& point_world,
                                                    const RollingShutterCamera& camera,
                                                    const ViewModel& model);

// How reprojection_residual() changes: with a step of the pose (translation along the world's axes,
// then a turn about the camera's own: see retract()), with the point, and with the readout time.
struct ReprojectionJacobians {
  Eigen::Matrix<double, 3, 6> d_pose;
  Eigen::Matrix3d d_point;
  Eigen::Vector3d d_readout;
};
// The point must lie in front of the camera.
[[nodiscard]] ReprojectionJacobians reprojection_jacobians(const LandmarkView& view,
                                                           const Eigen::Vector3d& point_world,
                                                           const RollingShutterCamera& camera,
                                                           const ViewModel& model);

}  // namespace roomwise::mapping
