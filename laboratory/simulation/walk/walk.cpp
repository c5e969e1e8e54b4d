#include "laboratory/simulation/walk/walk.h"

#include <algorithm>
#include <cmath>

#include "laboratory/simulation/home/home_geometry.h"
#include "laboratory/simulation/home/storeys.h"
#include "laboratory/simulation/walk/carried_camera.h"
#include "laboratory/simulation/walk/walk_motion.h"
#include "laboratory/simulation/walk/walk_route.h"

namespace roomwise::simulation {
namespace {

constexpr double kMaxFramesPerSecond = 1000;

// The camera in the hand of a walking person.
class HandHeldCamera {
 public:
  HandHeldCamera(std::vector<BodyState> states, const WalkOptions& options)
      : states_(std::move(states)), camera_(options) {}

  [[nodiscard]] double duration_s() const {
    return static_cast<double>(states_.size() - 1) * kMotionStep;
  }

  [[nodiscard]] geometry::RigidTransform pose_at(double time_s) const {
    return camera_.pose(state_at(time_s), time_s);
  }

 private:
  [[nodiscard]] BodyState state_at(double time_s) const {
    const double position =
        std::clamp(time_s / kMotionStep, 0.0, static_cast<double>(states_.size() - 1));
    const auto i = std::min(static_cast<std::size_t>(position), states_.size() - 1);
    const BodyState& a = states_[i];
    const BodyState& b = states_[std::min(i + 1, states_.size() - 1)];
    const double share = position - static_cast<double>(i);
    return {a.place + share * (b.place - a.place),
            a.heading_rad + share * (b.heading_rad - a.heading_rad),
            a.down_rad + share * (b.down_rad - a.down_rad),
            a.speed_m_s + share * (b.speed_m_s - a.speed_m_s),
            a.floor_m + share * (b.floor_m - a.floor_m)};
  }

  std::vector<BodyState> states_;
  CarriedCamera camera_;
};

}  // namespace

Expected<void> WalkOptions::validate() const {
  const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
  if (!(frames_per_second > 0 && frames_per_second <= kMaxFramesPerSecond)) {
    return fail("frames_per_second = {} must be positive and at most {}", frames_per_second,
                kMaxFramesPerSecond);
  }
  if (!(camera_height_m >= 0.5 && camera_height_m <= 1.8)) {
    return fail("camera_height_m = {} must be from 0.5 to 1.8", camera_height_m);
  }
  if (!positive(walking_speed_m_s)) {
    return fail("walking_speed_m_s = {} must be positive", walking_speed_m_s);
  }
  if (!positive(max_turning_rad_s)) {
    return fail("max_turning_rad_s = {} must be positive", max_turning_rad_s);
  }
  if (!(jitter >= 0 && jitter <= 2)) return fail("jitter = {} must be from 0 to 2", jitter);
  return {};
}

Expected<std::vector<WalkPose>> plan_walk(const HomeModel& home, const WalkOptions& options) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  if (home.rooms.empty()) return fail("a home without rooms cannot be walked through");
  ROOMWISE_TRY(const Route route, plan_route(home, options));
  const HandHeldCamera camera(walk_along(route, options), options);

  std::size_t frames =
      static_cast<std::size_t>(camera.duration_s() * options.frames_per_second) + 1;
  if (options.max_frames > 0) frames = std::min(frames, options.max_frames);
  std::vector<WalkPose> poses(frames);
  for (std::size_t i = 0; i < frames; ++i) {
    const double time_s = static_cast<double>(i) / options.frames_per_second;
    WalkPose& pose = poses[i];
    pose.timestamp_ns = static_cast<TimestampNs>(std::llround(time_s / kSecondsPerNs));
    pose.world_from_camera = camera.pose_at(time_s);
    pose.world_from_camera_open = camera.pose_at(time_s - kShutter_s / 2);
    pose.world_from_camera_close = camera.pose_at(time_s + kShutter_s / 2);
    const Eigen::Vector3d& camera_place = pose.world_from_camera.translation;
    pose.room = room_at(home, camera_place.head<2>(), camera_place.z() - options.camera_height_m);
  }
  return poses;
}

}  // namespace roomwise::simulation
