#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace roomwise::geometry {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// A rotation followed by a translation (SE(3)), lengths in metres. A variable a_from_b takes the
// coordinates of a point in frame b to its coordinates in frame a:
//   point_a = a_from_b * point_b;    a_from_c = a_from_b * b_from_c;
struct RigidTransform {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  // unit length
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  static RigidTransform identity() { return {}; }
  static RigidTransform from_matrix(const Eigen::Matrix3d& rotation,
                                    const Eigen::Vector3d& translation) {
    return {Eigen::Quaterniond(rotation).normalized(), translation};
  }
  // The exponential map of a twist (rotation vector in rad, then translational part in m).
  static RigidTransform exp(const Vector6d& twist);

  [[nodiscard]] RigidTransform inverse() const {
    const Eigen::Quaterniond back = rotation.conjugate();
    return {back, -(back * translation)};
  }
  [[nodiscard]] Eigen::Matrix3d rotation_matrix() const { return rotation.toRotationMatrix(); }
  // The angle of the rotation, in [0, pi] rad, exact for small angles too.
  [[nodiscard]] double angle_rad() const;
  // The length of the translation, m.
  [[nodiscard]] double distance_m() const { return translation.norm(); }
  [[nodiscard]] bool is_finite() const {
    return rotation.coeffs().allFinite() && translation.allFinite();
  }

  friend RigidTransform operator*(const RigidTransform& a_from_b, const RigidTransform& b_from_c) {
    return {(a_from_b.rotation * b_from_c.rotation).normalized(),
            a_from_b.rotation * b_from_c.translation + a_from_b.translation};
  }
  friend Eigen::Vector3d operator*(const RigidTransform& a_from_b, const Eigen::Vector3d& point_b) {
    return a_from_b.rotation * point_b + a_from_b.translation;
  }
};

// The matrix that takes w to v x w.
[[nodiscard]] Eigen::Matrix3d skew_symmetric(const Eigen::Vector3d& v);

}  // namespace roomwise::geometry
