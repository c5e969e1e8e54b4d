#include "laboratory/simulation/walk/inertial_sensor.h"

#include <algorithm>
#include <cmath>

#include "roomwise/base/random.h"

namespace roomwise::simulation {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using recording::StampedPose;

// A walk between its poses.
class SmoothWalk {
 public:
  explicit SmoothWalk(std::span<const StampedPose> poses)
      : poses_(poses), acceleration_m_s2_(poses.size(), Vector3d::Zero()) {
    solve_spline();
  }

  [[nodiscard]] Vector3d acceleration_m_s2(TimestampNs at_ns) const {
    const auto [i, share] = place(at_ns);
    return acceleration_m_s2_[i] + share * (acceleration_m_s2_[i + 1] - acceleration_m_s2_[i]);
  }
  [[nodiscard]] Quaterniond rotation(TimestampNs at_ns) const {
    const auto [i, share] = place(at_ns);
    return poses_[i].world_from_camera.rotation.slerp(share,
                                                      poses_[i + 1].world_from_camera.rotation);
  }

 private:
  [[nodiscard]] double duration_s(std::size_t i) const {
    return seconds_between(poses_[i].timestamp_ns, poses_[i + 1].timestamp_ns);
  }
  [[nodiscard]] Vector3d velocity_m_s(std::size_t i) const {
    return (poses_[i + 1].world_from_camera.translation - poses_[i].world_from_camera.translation) /
           duration_s(i);
  }
  [[nodiscard]] std::pair<std::size_t, double> place(TimestampNs at_ns) const {
    const auto after = std::ranges::upper_bound(poses_, at_ns, {}, &StampedPose::timestamp_ns);
    const auto i = std::clamp<std::ptrdiff_t>(after - poses_.begin() - 1, 0,
                                              static_cast<std::ptrdiff_t>(poses_.size()) - 2);
    const auto interval = static_cast<std::size_t>(i);
    return {interval,
            std::clamp(seconds_between(poses_[interval].timestamp_ns, at_ns) / duration_s(interval),
                       0.0, 1.0)};
  }
  // The accelerations at the poses (0 at both ends) with which velocities go on: a tridiagonal
  // system, h_i a_i + 2 (h_i + h_i+1) a_i+1 + h_i+1 a_i+2 = 6 (v_i+1 - v_i).
  void solve_spline() {
    const std::size_t last = poses_.size() - 1;
    std::vector<double> diagonal(poses_.size());
    for (std::size_t i = 1; i < last; ++i) {
      diagonal[i] = 2 * (duration_s(i - 1) + duration_s(i));
      acceleration_m_s2_[i] = 6 * (velocity_m_s(i) - velocity_m_s(i - 1));
      if (i == 1) continue;
      const double share = duration_s(i - 1) / diagonal[i - 1];
      diagonal[i] -= share * duration_s(i - 1);
      acceleration_m_s2_[i] -= share * acceleration_m_s2_[i - 1];
    }
    for (std::size_t i = last; i-- > 1;) {
      acceleration_m_s2_[i] =
          (acceleration_m_s2_[i] - duration_s(i) * acceleration_m_s2_[i + 1]) / diagonal[i];
    }
  }

  std::span<const StampedPose> poses_;
  std::vector<Vector3d> acceleration_m_s2_;
};

}  // namespace

Expected<void> InertialSensorOptions::validate() const {
  if (!(rate_hz >= 1 && rate_hz <= 10'000))
    return fail("rate_hz = {} must be from 1 to 10000", rate_hz);
  for (const double sigma :
       {turning_noise_rad_sqrt_s, turning_bias_rad_s, turning_walk_rad_s_sqrt_s, turning_scale,
        force_noise_m_s2_sqrt_s, force_bias_m_s2, force_walk_m_s2_sqrt_s}) {
    if (!(sigma >= 0 && std::isfinite(sigma)))
      return fail("what an inertial sensor errs by, {}, must not be negative", sigma);
  }
  return {};
}

geometry::InertialTrack simulate_inertial_sensor(std::span<const StampedPose> truth,
                                                 const InertialSensorOptions& options) {
  if (truth.size() < 2) return {};
  const SmoothWalk walk(truth);
  RandomStream random(options.seed, {0x696d75});
  const auto three = [&](double sigma) {
    return Vector3d(sigma * random.normal(), sigma * random.normal(), sigma * random.normal());
  };
  Vector3d turning_bias_rad_s = three(options.turning_bias_rad_s);
  Vector3d force_bias_m_s2 = three(options.force_bias_m_s2);
  const Vector3d scale = Vector3d::Ones() + three(options.turning_scale);
  const double step_s = 1 / options.rate_hz;
  const auto step_ns = static_cast<TimestampNs>(step_s / kSecondsPerNs);
  std::vector<geometry::InertialSample> samples;
  for (TimestampNs now = truth.front().timestamp_ns; now <= truth.back().timestamp_ns;
       now += step_ns) {
    const Quaterniond camera_from_world = walk.rotation(now).conjugate();
    // It measures the turn of a whole step, and is within the walk at both ends.
    const TimestampNs from = std::max(now - step_ns / 2, truth.front().timestamp_ns);
    const TimestampNs to = std::min(now + step_ns / 2, truth.back().timestamp_ns);
    const Vector3d turning_rad_s =
        to > from ? Vector3d(geometry::rotation_vector_rad(walk.rotation(from).conjugate() *
                                                           walk.rotation(to)) /
                             seconds_between(from, to))
                  : Vector3d::Zero();
    const Vector3d force_m_s2 = camera_from_world * (walk.acceleration_m_s2(now) +
                                                     geometry::kGravity_m_s2 * Vector3d::UnitZ());
    samples.push_back({now,
                       scale.cwiseProduct(turning_rad_s) + turning_bias_rad_s +
                           three(options.turning_noise_rad_sqrt_s / std::sqrt(step_s)),
                       force_m_s2 + force_bias_m_s2 +
                           three(options.force_noise_m_s2_sqrt_s / std::sqrt(step_s))});
    turning_bias_rad_s += three(options.turning_walk_rad_s_sqrt_s * std::sqrt(step_s));
    force_bias_m_s2 += three(options.force_walk_m_s2_sqrt_s * std::sqrt(step_s));
  }
  return {std::move(samples), true};
}

}  // namespace roomwise::simulation
