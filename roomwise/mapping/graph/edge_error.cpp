#include "roomwise/mapping/graph/edge_error.h"

#include <algorithm>

#include "roomwise/geometry/robust_loss.h"

namespace roomwise::mapping {
namespace {

using geometry::Matrix6d;
using geometry::RigidTransform;
using geometry::Vector6d;

// d's quaternion of PoseGraphEdge, with w >= 0.
Eigen::Quaterniond residual_rotation(const RigidTransform& from_from_to,
                                     const RigidTransform& world_from_from,
                                     const RigidTransform& world_from_to) {
  Eigen::Quaterniond turn = from_from_to.rotation.conjugate() *
                            (world_from_from.rotation.conjugate() * world_from_to.rotation);
  if (turn.w() < 0) turn.coeffs() *= -1;
  return turn;
}

geometry::RobustLoss loss_of(double squares, double kernel) {
  return kernel == 0 ? geometry::RobustLoss{squares, 1, 0} : geometry::cauchy_loss(squares, kernel);
}

}  // namespace

Vector6d edge_error(const RigidTransform& from_from_to, const RigidTransform& world_from_from,
                    const RigidTransform& world_from_to) {
  const Eigen::Vector3d estimated =
      world_from_from.rotation.conjugate() *
      (world_from_to.translation - world_from_from.translation).eval();
  Vector6d error;
  error.head<3>() =
      from_from_to.rotation.conjugate() * (estimated - from_from_to.translation).eval();
  error.tail<3>() = residual_rotation(from_from_to, world_from_from, world_from_to).vec();
  return error;
}

EdgeJacobians edge_jacobians(const RigidTransform& from_from_to,
                             const RigidTransform& world_from_from,
                             const RigidTransform& world_from_to) {
  const Eigen::Matrix3d measured_back = from_from_to.rotation.conjugate().toRotationMatrix();
  const Eigen::Matrix3d from_from_world = world_from_from.rotation.conjugate().toRotationMatrix();
  const Eigen::Vector3d estimated =
      from_from_world * (world_from_to.translation - world_from_from.translation);
  const Eigen::Quaterniond turn = residual_rotation(from_from_to, world_from_from, world_from_to);
  // Of a product of quaternions q (1, r / 2) the vector part changes by (w + v x) r / 2; of
  // (1, r / 2) q by (w - v x) r / 2.
  const Eigen::Matrix3d w = turn.w() * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d v = geometry::skew_symmetric(turn.vec());
  EdgeJacobians jacobians;
  jacobians.d_to << measured_back * from_from_world, Eigen::Matrix3d::Zero(),
      Eigen::Matrix3d::Zero(), 0.5 * (w + v);
  jacobians.d_from << -measured_back * from_from_world,
      measured_back * geometry::skew_symmetric(estimated), Eigen::Matrix3d::Zero(),
      -0.5 * (w - v) * measured_back;
  return jacobians;
}

double edge_cost(const PoseGraphEdge& edge, const RigidTransform& world_from_from,
                 const RigidTransform& world_from_to, double kernel) {
  const Vector6d error = edge_error(edge.from_from_to, world_from_from, world_from_to);
  return loss_of(error.dot(edge.information * error), kernel).value;
}

EdgeEquations linearize(const PoseGraphEdge& edge, const RigidTransform& world_from_from,
                        const RigidTransform& world_from_to, double kernel) {
  const Vector6d error = edge_error(edge.from_from_to, world_from_from, world_from_to);
  const auto [d_from, d_to] = edge_jacobians(edge.from_from_to, world_from_from, world_from_to);
  const Vector6d weighted_error = edge.information * error;
  const double squares = error.dot(weighted_error);
  const geometry::RobustLoss loss = loss_of(squares, kernel);
  Matrix6d weight = loss.derivative * edge.information;
  if (loss.second_derivative != 0) {
    // The kernel's second derivative, as far as the weight stays positive semi-definite.
    weight += std::max(2 * loss.second_derivative, -loss.derivative / squares) * weighted_error *
              weighted_error.transpose();
  }
  const Matrix6d from_weight = d_from.transpose() * weight;
  EdgeEquations equations;
  equations.from_hessian = from_weight * d_from;
  equations.to_hessian = d_to.transpose() * weight * d_to;
  equations.from_to_hessian = from_weight * d_to;
  equations.from_rhs = -loss.derivative * (d_from.transpose() * weighted_error);
  equations.to_rhs = -loss.derivative * (d_to.transpose() * weighted_error);
  return equations;
}

RigidTransform retract(const RigidTransform& world_from_node, const Vector6d& step) {
  // The quaternion of a rotation vector r is (cos |r/2|, r/2 sin |r/2| / |r/2|).
  const Eigen::Vector3d half = 0.5 * step.tail<3>();
  const double angle = half.norm();
  const double sinc = angle > 1e-8 ? std::sin(angle) / angle : 1.0;
  const Eigen::Vector3d vector = sinc * half;
  const Eigen::Quaterniond turn(std::cos(angle), vector.x(), vector.y(), vector.z());
  return {(world_from_node.rotation * turn).normalized(),
          world_from_node.translation + step.head<3>()};
}

}  // namespace roomwise::mapping
