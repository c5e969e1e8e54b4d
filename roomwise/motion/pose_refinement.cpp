#include "roomwise/motion/pose_refinement.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <optional>

#include "roomwise/geometry/levenberg_marquardt.h"
#include "roomwise/geometry/robust_loss.h"
#include "roomwise/motion/damped_step.h"

namespace roomwise::motion {
namespace {

using geometry::huber_loss;
using geometry::Matrix6d;
using geometry::PinholeCamera;
using geometry::RigidTransform;
using geometry::Vector6d;

constexpr double kHuberSigmas = 2.0;

// What levenberg_marquardt.h minimises.
class PoseProblem {
 public:
  PoseProblem(std::span<const PointObservation> observations,
              const RigidTransform& reference_from_current, const PinholeCamera& camera,
              const ResidualModel& model)
      : observations_(observations),
        camera_(camera),
        model_(model),
        reference_from_current_(reference_from_current) {}

  [[nodiscard]] double cost() const {
    double cost = 0;
    for_each_residual(
        [&](const PointObservation&, const RigidTransform&, const Eigen::Vector3d& error) {
          cost += huber_loss(error.squaredNorm(), kHuberSigmas).value;
        });
    return cost;
  }
  void linearize() {
    hessian_.setZero();
    rhs_.setZero();
    for_each_residual([&](const PointObservation& observation,
                          const RigidTransform& current_from_reference,
                          const Eigen::Vector3d& error) {
      if (!error.allFinite()) return;
      const auto jacobian = residual_jacobian(observation, current_from_reference, camera_, model_);
      const double weight = huber_loss(error.squaredNorm(), kHuberSigmas).derivative;
      hessian_ += weight * jacobian.transpose() * jacobian;
      rhs_ -= weight * jacobian.transpose() * error;
    });
  }
  [[nodiscard]] std::optional<geometry::DampedStep> solve(double damping) {
    return solve_damped(hessian_, rhs_, damping, step_);
  }
  void take_step() {
    before_ = reference_from_current_;
    reference_from_current_ = reference_from_current_ * RigidTransform::exp(step_);
  }
  void undo_step() { reference_from_current_ = before_; }

  [[nodiscard]] RefinedPose refined() {
    linearize();
    double squares = 0;
    for_each_residual([&](const PointObservation&, const RigidTransform&,
                          const Eigen::Vector3d& error) { squares += error.squaredNorm(); });
    return {reference_from_current_, edge_information(hessian_),
            std::sqrt(squares / static_cast<double>(observations_.size()))};
  }

 private:
  template <typename Visit>
  void for_each_residual(const Visit& visit) const {
    const RigidTransform current_from_reference = reference_from_current_.inverse();
    for (const PointObservation& observation : observations_)
      visit(observation, current_from_reference,
            residual(observation, current_from_reference, camera_, model_));
  }

  std::span<const PointObservation> observations_;
  const PinholeCamera& camera_;
  const ResidualModel& model_;
  RigidTransform reference_from_current_, before_;
  Matrix6d hessian_;
  Vector6d rhs_, step_;
};

}  // namespace

Eigen::Vector3d residual(const PointObservation& observation,
                         const RigidTransform& current_from_reference, const PinholeCamera& camera,
                         const ResidualModel& model) {
  return point_residual(current_from_reference * observation.point_reference,
                        observation.pixel_current, observation.depth_current_m, camera, model);
}

Eigen::Matrix<double, 3, 6> residual_jacobian(const PointObservation& observation,
                                              const RigidTransform& current_from_reference,
                                              const PinholeCamera& camera,
                                              const ResidualModel& model) {
  const Eigen::Vector3d point = current_from_reference * observation.point_reference;
  // The point changes by point x omega - v.
  Eigen::Matrix<double, 3, 6> d_twist;
  d_twist << geometry::skew_symmetric(point), -Eigen::Matrix3d::Identity();
  return point_residual_jacobian(point, observation.depth_current_m > 0, camera, model) * d_twist;
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
  // With I = L L^T, (I^-1 + S)^-1 = L (1 + L^T S L)^-1 L^T: no inverse of a curvature that may be
  // singular, and positive semi-definite however it rounds.
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(information);
  const Matrix6d root =
      eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
  const Matrix6d mixed = Matrix6d::Identity() + root.transpose() * systematic.asDiagonal() * root;
  const Matrix6d weakened = root * mixed.llt().solve(root.transpose());
  return 0.5 * (weakened + weakened.transpose());
}

RefinedPose refine_pose(std::span<const PointObservation> observations,
                        const RigidTransform& reference_from_current, const PinholeCamera& camera,
                        const ResidualModel& model) {
  constexpr geometry::MinimizerOptions kOptions{.max_iterations = 20, .min_step_length = 1e-9};
  PoseProblem problem(observations, reference_from_current, camera, model);
  geometry::minimize(problem, kOptions);
  return problem.refined();
}

}  // namespace roomwise::motion
