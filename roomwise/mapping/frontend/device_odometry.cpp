#include "roomwise/mapping/frontend/device_odometry.h"

#include <cmath>

namespace roomwise::mapping {
namespace {

using geometry::RigidTransform;

// Where picture and pose are a little out of step, and what filters smooth away.
constexpr double kPlaceSigma_m = 0.002;
constexpr double kPlaceSigma_rad = 0.001;
// Visual-inertial odometry of phones drifts by 0.5 to 2 % of the way, mostly by a wrong scale and
// by turning: errors that go on in the same direction, so that the share is taken whole.
constexpr double kDriftOfPath = 0.02;
constexpr double kDriftOfTurn = 0.01;
constexpr double kDrift_rad_m = 0.004;
// While it is silent it goes on by its inertial sensor alone.
constexpr double kSilent_m_s = 0.1;
constexpr double kSilent_rad_s = 0.03;
constexpr double kLongestSilence_s = 3;
// Nobody moves a camera in a home as fast as this: what a device says beyond is a jump.
constexpr double kFastest_m_s = 2;
constexpr double kFastest_rad_s = 7;
constexpr double kFastestSlack_m = 0.1;
constexpr double kFastestSlack_rad = 0.2;

}  // namespace

std::optional<motion::PosePrior> device_step(const DeviceMark& from, const DeviceMark& to) {
  if (from.breaks != to.breaks) return std::nullopt;
  const double path_m = std::abs(to.path_m - from.path_m);
  const double turned_rad = std::abs(to.turned_rad - from.turned_rad);
  const double silent_s = std::abs(to.silent_s - from.silent_s);
  return motion::PosePrior::around(
      from.world_from_camera.inverse() * to.world_from_camera,
      std::hypot(kPlaceSigma_m, kDriftOfPath * path_m, kSilent_m_s * silent_s),
      std::hypot(kPlaceSigma_rad, kDriftOfTurn * turned_rad + kDrift_rad_m * path_m,
                 kSilent_rad_s * silent_s));
}

PoseGraphEdge edge_from_device(KeyframeId from, KeyframeId to, const motion::PosePrior& step) {
  return {from, to, step.reference_from_current, step.information, true, true};
}

bool is_device_jump(const RigidTransform& step, double duration_s) {
  return step.distance_m() > kFastestSlack_m + kFastest_m_s * duration_s ||
         step.angle_rad() > kFastestSlack_rad + kFastest_rad_s * duration_s;
}

std::optional<DeviceMark> DeviceOdometry::mark(const scene::Frame& next) const {
  if (!next.motion) return std::nullopt;
  const RigidTransform& pose = next.motion->device.world_from_camera;
  if (!last_) return DeviceMark{pose};
  const RigidTransform step = last_->world_from_camera.inverse() * pose;
  const double duration_s = seconds_between(last_ns_, next.timestamp_ns);
  DeviceMark mark = *last_;
  mark.world_from_camera = pose;
  mark.path_m += step.distance_m();
  mark.turned_rad += step.angle_rad();
  if (is_silent_) mark.silent_s += duration_s;
  const bool is_long_silent = is_silent_ && duration_s > kLongestSilence_s;
  if (is_long_silent || next.motion->use == scene::MotionUse::kDropped) ++mark.breaks;
  return mark;
}

bool DeviceOdometry::jumps_to(const scene::Frame& next) const {
  if (!next.motion || !last_) return false;
  const RigidTransform step =
      last_->world_from_camera.inverse() * next.motion->device.world_from_camera;
  return is_device_jump(step, seconds_between(last_ns_, next.timestamp_ns));
}

void DeviceOdometry::pass(const scene::Frame& frame) {
  if (const auto marked = mark(frame)) {
    last_ = marked;
    last_ns_ = frame.timestamp_ns;
  }
  is_silent_ = !frame.motion;
}

}  // namespace roomwise::mapping
