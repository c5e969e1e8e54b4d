#include "roomwise/mapping/graph/edge_error.h"

namespace roomwise::mapping {
namespace {

using geometry::Matrix6d;
using geometry::RigidTransform;
using geometry::Vector6d;

// d's quaternion of PoseGraphEdge, with w >= 0.
Eigen::Quaterniond remaining_turn(const RigidTransform& from_from_to,
                                  const RigidTransform& world_from_from,
                                  const RigidTransform& world_from_to) {
  Eigen::Quaterniond turn = from_from_to.rotation.conjugate() *
                            (world_from_from.rotation.conjugate() * world_from_to.rotation);
  if (turn.w() < 0) turn.coeffs() *= -1;
  return turn;
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
  error.tail<3>() = remaining_turn(from_from_to, world_from_from, world_from_to).vec();
  return error;
}

EdgeJacobians edge_jacobians(const RigidTransform& from_from_to,
                             const RigidTransform& world_from_from,
                             const RigidTransform& world_from_to) {
  const Eigen::Matrix3d measured_back = from_from_to.rotation.conjugate().toRotationMatrix();
  const Eigen::Matrix3d from_from_world = world_from_from.rotation.conjugate().toRotationMatrix();
  const Eigen::Vector3d estimated =
      from_from_world * (world_from_to.translation - world_from_from.translation);
  const Eigen::Quaterniond turn = remaining_turn(from_from_to, world_from_from, world_from_to);
  // Of a product of quaternions q (1, r / 2) the vector part changes by (w + v x) r / 2; of
  // (1, r / 2) q by (w - v x) r / 2.
  const Eigen::Matrix3d w = turn.w() * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d v = geometry::skew_symmetric(turn.vec());
  EdgeJacobians jacobians;
  jacobians.by_to << measured_back * from_from_world, Eigen::Matrix3d::Zero(),
      Eigen::Matrix3d::Zero(), 0.5 * (w + v);
  jacobians.by_from << -measured_back * from_from_world,
      measured_back * geometry::skew_symmetric(estimated), Eigen::Matrix3d::Zero(),
      -0.5 * (w - v) * measured_back;
  return jacobians;
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
