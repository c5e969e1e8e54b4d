#include "roomwise/geometry/rigid_transform.h"

#include <cmath>

namespace roomwise::geometry {

Eigen::Matrix3d skew_symmetric(const Eigen::Vector3d& v) {
  return Eigen::Matrix3d{{0, -v.z(), v.y()}, {v.z(), 0, -v.x()}, {-v.y(), v.x(), 0}};
}

RigidTransform RigidTransform::exp(const Vector6d& twist) {
  const Eigen::Vector3d omega = twist.head<3>();
  const double theta = omega.norm();
  const Eigen::Matrix3d hat = skew_symmetric(omega);
  Eigen::Quaterniond rotation;
  Eigen::Matrix3d left_jacobian;
  if (theta < 1e-6) {
    // Second-order series: the closed forms below lose their digits here.
    rotation =
        Eigen::Quaterniond(1.0 - theta * theta / 8, omega.x() / 2, omega.y() / 2, omega.z() / 2);
    left_jacobian = Eigen::Matrix3d::Identity() + 0.5 * hat + hat * hat / 6;
  } else {
    const Eigen::Vector3d imaginary = std::sin(theta / 2) / theta * omega;
    rotation = Eigen::Quaterniond(std::cos(theta / 2), imaginary.x(), imaginary.y(), imaginary.z());
    left_jacobian = Eigen::Matrix3d::Identity() + (1 - std::cos(theta)) / (theta * theta) * hat +
                    (theta - std::sin(theta)) / (theta * theta * theta) * hat * hat;
  }
  return {rotation.normalized(), left_jacobian * twist.tail<3>()};
}

double RigidTransform::angle_rad() const {
  return 2.0 * std::atan2(rotation.vec().norm(), std::abs(rotation.w()));
}

}  // namespace roomwise::geometry
