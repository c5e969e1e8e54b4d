#include "roomwise/mapping/backend/up_measurement.h"

#include <Eigen/LU>
#include <cmath>

#include "roomwise/geometry/inertial_track.h"

namespace roomwise::mapping {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using geometry::RigidTransform;

// The normal equations of the small turn (rad, about the camera's axes) that brings up to where the
// normals say it is, in units of one normal's information.
struct TurnEquations {
  Matrix3d hessian = Matrix3d::Zero();
  Vector3d rhs = Vector3d::Zero();
};

TurnEquations turn_equations(std::span<const Eigen::Vector3f> normals, const Vector3d& up,
                             double inlier_angle_rad) {
  const double min_level = std::cos(inlier_angle_rad);
  const double max_upright = std::sin(inlier_angle_rad);
  TurnEquations equations;
  for (const Eigen::Vector3f& one : normals) {
    const Vector3d normal = one.cast<double>();
    const double along = normal.dot(up);
    const Vector3d axis = up.cross(normal);
    if (std::abs(along) >= min_level) {
      equations.hessian += Matrix3d::Identity() - up * up.transpose();
      equations.rhs += along < 0 ? Vector3d(-axis) : axis;
    } else if (std::abs(along) <= max_upright) {
      equations.hessian += axis * axis.transpose();
      equations.rhs -= along * axis;
    }
  }
  return equations;
}

// Two axes across a direction.
Eigen::Matrix<double, 3, 2> across_of(const Vector3d& up) {
  Eigen::Matrix<double, 3, 2> across;
  across.col(0) = up.unitOrthogonal();
  across.col(1) = up.cross(across.col(0));
  return across;
}

// The smallest turn that takes one direction to the other, as a rotation vector.
Vector3d turn_between(const Vector3d& from, const Vector3d& to) {
  return geometry::rotation_vector_rad(Eigen::Quaterniond::FromTwoVectors(from, to));
}

}  // namespace

Expected<void> UpMeasurementOptions::validate() const {
  if (!(inlier_angle_rad > 0 && inlier_angle_rad < 0.5))
    return fail("inlier_angle_rad = {} must be above 0 and below 0.5", inlier_angle_rad);
  if (!(normal_sigma_rad > 0))
    return fail("normal_sigma_rad = {} must be positive", normal_sigma_rad);
  if (!(systematic_sigma_rad > 0))
    return fail("systematic_sigma_rad = {} must be positive", systematic_sigma_rad);
  if (!(delay_s >= 0)) return fail("delay_s = {} must not be negative", delay_s);
  return {};
}

std::optional<UpMeasurement> measure_up(std::span<const Eigen::Vector3f> normals_camera,
                                        const Vector3d& expected_up_camera,
                                        const Vector3d& turning_rad_s,
                                        const UpMeasurementOptions& options) {
  // The expected direction counts as one normal: along a wall, where that is all there is to see,
  // it decides.
  constexpr double kExpected = 1;
  Vector3d up = expected_up_camera;
  Eigen::Matrix<double, 3, 2> across;  // what a turn of up may be about
  Matrix2d known;
  // Which normals count follows from up, and up from these.
  constexpr int kRefinements = 5;
  for (int i = 0; i < kRefinements; ++i) {
    TurnEquations equations = turn_equations(normals_camera, up, options.inlier_angle_rad);
    if (equations.hessian.isZero()) return std::nullopt;
    equations.rhs += kExpected * up.cross(expected_up_camera);
    across = across_of(up);
    known = across.transpose() * equations.hessian * across;
    const Matrix2d with_expected = known + kExpected * Matrix2d::Identity();
    const Vector3d turn = across * (with_expected.inverse() * (across.transpose() * equations.rhs));
    up = (up + turn.cross(up)).normalized();
  }
  if (up.dot(expected_up_camera) < std::cos(options.inlier_angle_rad)) return std::nullopt;
  constexpr double kLittle = 1e-3;  // of a normal: not to divide by nothing
  const Vector2d lag = options.delay_s * across.transpose() * turning_rad_s;
  const double systematic = options.systematic_sigma_rad;
  const Matrix2d covariance = options.normal_sigma_rad * options.normal_sigma_rad *
                                  (known + kLittle * Matrix2d::Identity()).inverse() +
                              systematic * systematic * Matrix2d::Identity() +
                              lag * lag.transpose();
  return UpMeasurement{up, across * covariance.inverse() * across.transpose()};
}

UpMeasurement felt_up(const Vector3d& up_camera) {
  constexpr double kInformation = 1 / (geometry::kUpSigma_rad * geometry::kUpSigma_rad);
  return {up_camera, kInformation * (Matrix3d::Identity() - up_camera * up_camera.transpose())};
}

bool contradict(const UpMeasurement& one, const UpMeasurement& other) {
  constexpr double kContradiction = 13.8;  // two degrees of freedom
  const Eigen::Matrix<double, 3, 2> across = across_of(one.up_camera);
  const auto covariance = [&](const UpMeasurement& measured) {
    return Matrix2d((across.transpose() * measured.information * across).inverse());
  };
  const Vector2d apart = across.transpose() * turn_between(one.up_camera, other.up_camera);
  return apart.dot((covariance(one) + covariance(other)).inverse() * apart) > kContradiction;
}

UpMeasurement together(const UpMeasurement& one, const UpMeasurement& other) {
  const Eigen::Matrix<double, 3, 2> across = across_of(one.up_camera);
  const Matrix2d of_other = across.transpose() * other.information * across;
  const Matrix2d of_both = across.transpose() * one.information * across + of_other;
  const Vector2d apart = across.transpose() * turn_between(one.up_camera, other.up_camera);
  const Vector3d turn = across * (of_both.inverse() * (of_other * apart));
  const Vector3d up = geometry::rotation_by(turn) * one.up_camera;
  const Matrix3d level = Matrix3d::Identity() - up * up.transpose();
  return {up, level * (one.information + other.information) * level};
}

PoseGraphEdge up_edge(NodeId ground, const RigidTransform& world_from_ground, NodeId keyframe,
                      const RigidTransform& world_from_keyframe, const UpMeasurement& measurement,
                      double kernel_sigmas) {
  PoseGraphEdge edge;
  edge.from = ground;
  edge.to = keyframe;
  edge.from_from_to = world_from_ground.inverse() * world_from_keyframe;
  // The smallest turn that brings the key-frame's up to the ground's.
  const Vector3d up_ground = edge.from_from_to.rotation * measurement.up_camera;
  const auto upright = Eigen::Quaterniond::FromTwoVectors(up_ground, Vector3d::UnitZ());
  edge.from_from_to.rotation = (upright * edge.from_from_to.rotation).normalized();
  const Eigen::AngleAxisd turn(upright);
  const Vector3d turn_camera =
      edge.from_from_to.rotation.conjugate() * Vector3d(turn.angle() * turn.axis());
  const double squared = turn_camera.dot(measurement.information * turn_camera);
  const double weight = 1 / (1 + squared / (kernel_sigmas * kernel_sigmas));
  edge.information.setZero();
  // The edge's error is half the turn.
  edge.information.bottomRightCorner<3, 3>() = 4 * weight * measurement.information;
  return edge;
}

}  // namespace roomwise::mapping
