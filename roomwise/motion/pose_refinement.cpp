#include "roomwise/motion/pose_refinement.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <limits>

namespace roomwise::motion {
namespace {

using geometry::Matrix6d;
using geometry::PinholeCamera;
using geometry::RigidTransform;
using geometry::Vector6d;

constexpr double kHuberSigmas = 2.0;

// Huber's cost of a squared residual, and its derivative by that square.
double huber_cost(double squared) {
  const double norm = std::sqrt(squared);
  return norm <= kHuberSigmas ? squared : kHuberSigmas * (2 * norm - kHuberSigmas);
}
double weight_of_squared(double squared) {
  const double norm = std::sqrt(squared);
  return norm <= kHuberSigmas ? 1.0 : kHuberSigmas / norm;
}

double total_cost(std::span<const PointObservation> observations,
                  const RigidTransform& reference_from_current, const PinholeCamera& camera,
                  const ResidualModel& model) {
  const RigidTransform current_from_reference = reference_from_current.inverse();
  double cost = 0;
  for (const PointObservation& observation : observations) {
    cost += huber_cost(residual(observation, current_from_reference, camera, model).squaredNorm());
  }
  return cost;
}

// Derivative of the residual by a perturbation (omega, v) with reference_from_current * exp(omega,
// v).
Eigen::Matrix<double, 3, 6> residual_jacobian(const PointObservation& observation,
                                              const Eigen::Vector3d& point_current,
                                              const PinholeCamera& camera,
                                              const ResidualModel& model) {
  const double inverse_z = 1 / point_current.z();
  Eigen::Matrix3d by_point = Eigen::Matrix3d::Zero();
  by_point(0, 0) = camera.fx * inverse_z / model.pixel_sigma_px;
  by_point(0, 2) = -camera.fx * point_current.x() * inverse_z * inverse_z / model.pixel_sigma_px;
  by_point(1, 1) = camera.fy * inverse_z / model.pixel_sigma_px;
  by_point(1, 2) = -camera.fy * point_current.y() * inverse_z * inverse_z / model.pixel_sigma_px;
  if (observation.depth_current_m > 0) {
    by_point(2, 2) = -model.focal_baseline_px_m * inverse_z * inverse_z / model.disparity_sigma_px;
  }
  // point_current changes by point x omega - v.
  Eigen::Matrix<double, 3, 6> point_by_twist;
  point_by_twist << 0, -point_current.z(), point_current.y(), -1, 0, 0,  //
      point_current.z(), 0, -point_current.x(), 0, -1, 0,                //
      -point_current.y(), point_current.x(), 0, 0, 0, -1;
  return by_point * point_by_twist;
}

struct PoseEquations {
  Matrix6d hessian = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
};

PoseEquations linearize(std::span<const PointObservation> observations,
                        const RigidTransform& reference_from_current, const PinholeCamera& camera,
                        const ResidualModel& model) {
  const RigidTransform current_from_reference = reference_from_current.inverse();
  PoseEquations equations;
  for (const PointObservation& observation : observations) {
    const Eigen::Vector3d point_current = current_from_reference * observation.point_reference;
    if (!(point_current.z() > 0)) continue;
    const Eigen::Vector3d error = residual(observation, current_from_reference, camera, model);
    const auto jacobian = residual_jacobian(observation, point_current, camera, model);
    const double weight = weight_of_squared(error.squaredNorm());
    equations.hessian += weight * jacobian.transpose() * jacobian;
    equations.gradient += weight * jacobian.transpose() * error;
  }
  return equations;
}

}  // namespace

Eigen::Vector3d residual(const PointObservation& observation,
                         const RigidTransform& current_from_reference, const PinholeCamera& camera,
                         const ResidualModel& model) {
  const Eigen::Vector3d point_current = current_from_reference * observation.point_reference;
  if (!(point_current.z() > 0))
    return Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  const Eigen::Vector2d pixel =
      camera.project_undistorted(point_current) - observation.pixel_current;
  const double disparity =
      observation.depth_current_m > 0
          ? model.focal_baseline_px_m * (1 / point_current.z() - 1 / observation.depth_current_m)
          : 0.0;
  return {pixel.x() / model.pixel_sigma_px, pixel.y() / model.pixel_sigma_px,
          disparity / model.disparity_sigma_px};
}

Matrix6d edge_information(const Matrix6d& hessian) {
  Matrix6d information;
  information.topLeftCorner<3, 3>() = hessian.bottomRightCorner<3, 3>();
  information.topRightCorner<3, 3>() = 2 * hessian.bottomLeftCorner<3, 3>();
  information.bottomLeftCorner<3, 3>() = 2 * hessian.topRightCorner<3, 3>();
  information.bottomRightCorner<3, 3>() = 4 * hessian.topLeftCorner<3, 3>();
  return information;
}

Matrix6d twist_information(const Matrix6d& information) {
  Matrix6d hessian;
  hessian.topLeftCorner<3, 3>() = 0.25 * information.bottomRightCorner<3, 3>();
  hessian.topRightCorner<3, 3>() = 0.5 * information.bottomLeftCorner<3, 3>();
  hessian.bottomLeftCorner<3, 3>() = 0.5 * information.topRightCorner<3, 3>();
  hessian.bottomRightCorner<3, 3>() = information.topLeftCorner<3, 3>();
  return hessian;
}

Matrix6d with_systematic_error(const Matrix6d& information, double translation_sigma_m,
                               double half_angle_sigma) {
  Vector6d systematic;
  systematic.head<3>().setConstant(translation_sigma_m * translation_sigma_m);
  systematic.tail<3>().setConstant(half_angle_sigma * half_angle_sigma);
  // (I^-1 + S)^-1 = (I S + 1)^-1 I, which needs no inverse of a curvature that may be singular.
  const Matrix6d mixed = information * systematic.asDiagonal() + Matrix6d::Identity();
  const Matrix6d weakened = mixed.partialPivLu().solve(information);
  return 0.5 * (weakened + weakened.transpose());
}

RefinedPose refine_pose(std::span<const PointObservation> observations,
                        const RigidTransform& reference_from_current, const PinholeCamera& camera,
                        const ResidualModel& model) {
  constexpr int kMaxIterations = 20;
  constexpr double kMinStep = 1e-9;
  RigidTransform pose = reference_from_current;
  double cost = total_cost(observations, pose, camera, model);
  double damping = 1e-6;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const PoseEquations equations = linearize(observations, pose, camera, model);
    Matrix6d damped = equations.hessian;
    damped.diagonal() += damping * equations.hessian.diagonal();
    const Vector6d step = -damped.ldlt().solve(equations.gradient);
    if (!step.allFinite()) break;
    const RigidTransform candidate = pose * RigidTransform::exp(step);
    const double candidate_cost = total_cost(observations, candidate, camera, model);
    if (candidate_cost < cost) {
      pose = candidate;
      cost = candidate_cost;
      damping = std::max(damping * 0.1, 1e-9);
    } else {
      damping *= 100;
    }
    if (step.norm() < kMinStep || damping > 1e6) break;
  }

  const RigidTransform current_from_reference = pose.inverse();
  double squares = 0;
  for (const PointObservation& observation : observations) {
    squares += residual(observation, current_from_reference, camera, model).squaredNorm();
  }
  return {pose, edge_information(linearize(observations, pose, camera, model).hessian),
          std::sqrt(squares / static_cast<double>(observations.size()))};
}

}  // namespace roomwise::motion
