#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "roomwise/base/timestamp.h"

namespace roomwise::geometry {

// The acceleration of free fall, m/s^2 (the standard's, CGPM 1901; over the earth within 0.3 %).
constexpr double kGravity_m_s2 = 9.80665;

// What an inertial sensor felt at a moment, in the camera's frame.
struct InertialSample {
  TimestampNs timestamp_ns = 0;
  Eigen::Vector3d turning_rad_s = Eigen::Vector3d::Zero();  // about the camera's axes
  Eigen::Vector3d force_m_s2 = Eigen::Vector3d::Zero();  // specific force: at rest gravity, upwards
};

// What an inertial sensor felt along a walk: how the camera turned, and where up is. Plain
// integration: what the sensor errs by (bias, scale) is for who uses it to find.
class InertialTrack {
 public:
  InertialTrack() = default;
  // The samples' times must increase, their numbers be finite. Accelerometers alone tell no turns.
  InertialTrack(std::vector<InertialSample> samples, bool tells_turns);

  [[nodiscard]] bool empty() const { return samples_.empty(); }
  [[nodiscard]] const std::vector<InertialSample>& samples() const { return samples_; }
  [[nodiscard]] bool tells_turns() const { return tells_turns_; }

  // How the camera is turned in a world of the sensor's own: that of the first sample, across gaps
  // as if it had not turned there; of an accelerometer alone one whose z is up and which turns
  // about that as it may. Nothing where there are no samples, or up is not felt.
  [[nodiscard]] std::optional<Eigen::Quaterniond> world_from_camera(TimestampNs at_ns) const;
  // Whether no samples are missing between the two, for longer than a hand keeps on turning as it
  // did (0.1 s).
  [[nodiscard]] bool is_unbroken(TimestampNs from_ns, TimestampNs to_ns) const;
  // How the camera turned from one moment to a later one, where the sensor's turns are too large by
  // a bias: from_from_to. Nothing where samples are missing or tell no turns.
  [[nodiscard]] std::optional<Eigen::Quaterniond> turn(
      TimestampNs from_ns, TimestampNs to_ns,
      const Eigen::Vector3d& bias_rad_s = Eigen::Vector3d::Zero()) const;
  // How it turns at a moment, rad/s about the camera's axes; nothing as with turn().
  [[nodiscard]] std::optional<Eigen::Vector3d> turning_rad_s(TimestampNs at_ns) const;
  // The direction up in the camera's frame, unit length: the mean force over a second, turned as
  // the camera turned, or over 0.2 s where turns are not known. Nothing where it is not as long as
  // gravity, or is not the same before and after: somebody shakes it.
  [[nodiscard]] std::optional<Eigen::Vector3d> up_camera(TimestampNs at_ns) const;

 private:
  // The place of the last sample at or before that time that has one behind it, too.
  [[nodiscard]] std::optional<std::size_t> interval(TimestampNs at_ns) const;
  [[nodiscard]] Eigen::Quaterniond turned(std::size_t interval, TimestampNs at_ns) const;

  std::vector<InertialSample> samples_;
  bool tells_turns_ = false;
  std::vector<Eigen::Quaterniond> turned_;  // at each sample, in the first one's frame
};

// How sure up_camera() is, rad about each of two axes: the sensor's own offset (40 mg, the data
// sheet of Bosch's BMI160), and as much again of a hand that grows faster by 0.4 m/s in a second.
// TUM's fr1/rpy, whose sensor is worse, has 0.056 rad.
constexpr double kUpSigma_rad = 0.06;

// A rotation vector, rad, as a rotation.
[[nodiscard]] Eigen::Quaterniond rotation_by(const Eigen::Vector3d& rotation_vector_rad);
// And back, the shorter way.
[[nodiscard]] Eigen::Vector3d rotation_vector_rad(const Eigen::Quaterniond& rotation);

}  // namespace roomwise::geometry
