#pragma once

#include <Eigen/Core>
#include <span>

#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/motion/point_residual.h"

namespace roomwise::motion {

// A point of the reference frame and where the current frame sees it.
struct PointObservation {
  Eigen::Vector3d point_reference;  // m
  Eigen::Vector2d pixel_current;    // undistorted
  double depth_current_m = 0;       // as measured by the current frame; 0: not measured
};

// point_residual() of an observation at a pose.
[[nodiscard]] Eigen::Vector3d residual(const PointObservation& observation,
                                       const geometry::RigidTransform& current_from_reference,
                                       const geometry::PinholeCamera& camera,
                                       const ResidualModel& model);

// Its derivative by a twist (omega, v) of the current frame, reference_from_current * exp(twist).
// The point must lie in front of the camera.
[[nodiscard]] Eigen::Matrix<double, 3, 6> residual_jacobian(
    const PointObservation& observation, const geometry::RigidTransform& current_from_reference,
    const geometry::PinholeCamera& camera, const ResidualModel& model);

struct RefinedPose {
  geometry::RigidTransform reference_from_current;
  // Inverse covariance of the pose in the order and the parameters of mapping/pose_graph.h's edge
  // error (x, y, z, qx, qy, qz of the current frame), from the curvature at the minimum.
  geometry::Matrix6d information = geometry::Matrix6d::Zero();
  double rms = 0;  // root mean square of |residual| over the observations, in sigmas
};

// From the curvature by a twist (omega, v) of the current frame to the information of an edge in
// (x, y, z, qx, qy, qz), where the quaternion's vector part is omega / 2; and back.
[[nodiscard]] geometry::Matrix6d edge_information(const geometry::Matrix6d& hessian);
[[nodiscard]] geometry::Matrix6d twist_information(const geometry::Matrix6d& information);

// The information when errors that the residuals do not show, independent and of these sizes, are
// added to the covariance: hundreds of inliers must not claim micrometres.
[[nodiscard]] geometry::Matrix6d with_systematic_error(const geometry::Matrix6d& information,
                                                       double translation_sigma_m,
                                                       double half_angle_sigma);

// Minimises the sum of squared residuals (Huber's kernel at 2 sigma) by Levenberg and Marquardt's
// method. At least three observations.
[[nodiscard]] RefinedPose refine_pose(std::span<const PointObservation> observations,
                                      const geometry::RigidTransform& reference_from_current,
                                      const geometry::PinholeCamera& camera,
                                      const ResidualModel& model);

}  // namespace roomwise::motion
