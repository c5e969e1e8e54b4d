#include "roomwise/mapping/graph/edge_composition.h"

#include <Eigen/LU>

namespace roomwise::mapping {
namespace {

using geometry::Matrix6d;
using geometry::RigidTransform;

// What an edge does not determine at all counts as very unsure.
Matrix6d covariance_of(const PoseGraphEdge& edge) {
  constexpr double kMinInformation = 1e-6;
  return (edge.information + kMinInformation * Matrix6d::Identity()).inverse();
}

Matrix6d information_of(const Matrix6d& covariance) {
  const Matrix6d inverse = covariance.inverse();
  return 0.5 * (inverse + inverse.transpose());
}

// Takes an error (m, half an angle in rad) that stands right of A = `pose` to its left: A e = e' A.
Matrix6d adjoint_of(const RigidTransform& pose) {
  const Eigen::Matrix3d rotation = pose.rotation_matrix();
  Matrix6d adjoint = Matrix6d::Zero();
  adjoint.topLeftCorner<3, 3>() = adjoint.bottomRightCorner<3, 3>() = rotation;
  adjoint.topRightCorner<3, 3>() = 2 * geometry::skew_symmetric(pose.translation) * rotation;
  return adjoint;
}

}  // namespace

PoseGraphEdge reversed(const PoseGraphEdge& edge) {
  // (A e)^-1 = A^-1 (A e^-1 A^-1).
  const Matrix6d adjoint = adjoint_of(edge.from_from_to);
  PoseGraphEdge back = edge;
  back.from = edge.to;
  back.to = edge.from;
  back.from_from_to = edge.from_from_to.inverse();
  back.information = information_of(adjoint * covariance_of(edge) * adjoint.transpose());
  return back;
}

PoseGraphEdge composed(const PoseGraphEdge& first, const PoseGraphEdge& second) {
  // A a B b = A B (B^-1 a B) b.
  const Matrix6d adjoint = adjoint_of(second.from_from_to.inverse());
  PoseGraphEdge both;
  both.from = first.from;
  both.to = second.to;
  both.from_from_to = first.from_from_to * second.from_from_to;
  both.information =
      information_of(adjoint * covariance_of(first) * adjoint.transpose() + covariance_of(second));
  both.is_robust = true;
  both.is_device_motion = first.is_device_motion || second.is_device_motion;
  return both;
}

double variance_of(const PoseGraphEdge& edge) {
  const Matrix6d covariance = covariance_of(edge);
  return covariance.topLeftCorner<3, 3>().trace() +
         4 * covariance.bottomRightCorner<3, 3>().trace();
}

}  // namespace roomwise::mapping
