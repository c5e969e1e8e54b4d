#pragma once

#include <optional>

#include "roomwise/geometry/inertial_track.h"

namespace roomwise::mapping {

// A turn, with what it is known to.
struct MeasuredTurn {
  Eigen::Quaterniond from_from_to = Eigen::Quaterniond::Identity();
  double sigma_rad = 0;  // about each axis
};

// How a camera turns by its inertial sensor. What the sensor says while it stands still (its bias)
// is found from turns that pictures show, one after the other: a Kalman filter, the same for each
// axis.
class Gyroscope {
 public:
  explicit Gyroscope(geometry::InertialTrack track) : track_(std::move(track)) {}

  [[nodiscard]] const geometry::InertialTrack& track() const { return track_; }
  // From one moment to a later one, in the camera's frame, its bias taken out; nothing where
  // samples are missing or tell no turns.
  [[nodiscard]] std::optional<MeasuredTurn> turn(TimestampNs from_ns, TimestampNs to_ns) const;
  // The same turn as pictures show it. One that cannot be is left out.
  void learn(TimestampNs from_ns, TimestampNs to_ns, const Eigen::Quaterniond& shown);
  [[nodiscard]] const Eigen::Vector3d& bias_rad_s() const { return bias_rad_s_; }
  [[nodiscard]] double bias_sigma_rad_s() const { return bias_sigma_rad_s_; }

 private:
  static constexpr double kFirstBiasSigma_rad_s = 0.05;  // 3 degrees a second

  geometry::InertialTrack track_;
  Eigen::Vector3d bias_rad_s_ = Eigen::Vector3d::Zero();
  double bias_sigma_rad_s_ = kFirstBiasSigma_rad_s;
};

}  // namespace roomwise::mapping
