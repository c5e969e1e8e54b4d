#include "laboratory/simulation/walk/walk.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "laboratory/simulation/home/home_geometry.h"
#include "laboratory/simulation/home/storeys.h"
#include "laboratory/simulation/walk/walk_motion.h"
#include "laboratory/simulation/walk/walk_route.h"
#include "roomwise/base/random.h"

namespace roomwise::simulation {
namespace {

constexpr double kMaxFramesPerSecond = 1000;
constexpr double kShutter = 0.02;      // seconds open
constexpr double kStepRate = 1.8;      // steps a second at walking speed
constexpr double kBob = 0.015;         // m, up and down with each step
constexpr double kSway = 0.012;        // m, to either side with every other
constexpr double kHandShift = 0.0025;  // m, one sigma of each sine
constexpr double kHandTurn = 0.003;    // rad

// A smooth random wandering: a few sines of random pitch and phase.
class Wandering {
 public:
  Wandering(RandomStream& random, double amplitude) {
    for (Sine& sine : sines_) {
      sine.rate = 2 * std::numbers::pi * (0.2 + 2.3 * random.uniform());
      sine.phase = 2 * std::numbers::pi * random.uniform();
      // The quicker, the smaller.
      sine.amplitude = amplitude * random.normal() / std::max(1.0, sine.rate / 4);
    }
  }
  [[nodiscard]] double at(double time_s) const {
    double sum = 0;
    for (const Sine& sine : sines_) {
      sum += sine.amplitude * std::sin(sine.rate * time_s + sine.phase);
    }
    return sum;
  }

 private:
  struct Sine {
    double rate = 0, phase = 0, amplitude = 0;
  };
  std::array<Sine, 4> sines_;
};

// The camera in the hand of a walking person.
class HandHeldCamera {
 public:
  HandHeldCamera(std::vector<BodyState> states, const WalkOptions& options)
      : states_(std::move(states)), options_(options) {
    RandomStream random(options.seed, {0x68616e64});
    for (Wandering& shift : shifts_) shift = Wandering(random, kHandShift);
    for (Wandering& turn : turns_) turn = Wandering(random, kHandTurn);
  }

  [[nodiscard]] double duration_s() const {
    return static_cast<double>(states_.size() - 1) * kMotionStep;
  }

  [[nodiscard]] geometry::RigidTransform pose_at(double time_s) const {
    const BodyState state = state_at(time_s);
    const double gait = std::min(1.0, state.speed_m_s / options_.walking_speed_m_s);
    const double phase = 2 * std::numbers::pi * kStepRate * time_s;
    const double jitter = options_.jitter;
    const Eigen::Vector2d ahead(std::cos(state.heading_rad), std::sin(state.heading_rad));
    const Eigen::Vector2d aside(-ahead.y(), ahead.x());
    const Eigen::Vector2d place =
        state.place +
        jitter * (aside * (kSway * gait * std::sin(phase / 2) + shifts_[0].at(time_s)) +
                  ahead * shifts_[1].at(time_s));
    const double height = state.floor_m + options_.camera_height_m +
                          jitter * (kBob * gait * std::sin(phase) + shifts_[2].at(time_s));
    const double heading = state.heading_rad + jitter * turns_[0].at(time_s);
    const double down = state.down_rad + jitter * turns_[1].at(time_s);
    const double roll = jitter * turns_[2].at(time_s);

    const Eigen::Vector3d forward(std::cos(heading) * std::cos(down),
                                  std::sin(heading) * std::cos(down), -std::sin(down));
    const Eigen::Vector3d right(std::sin(heading), -std::cos(heading), 0);
    Eigen::Matrix3d level;
    level << right, forward.cross(right), forward;
    const Eigen::Matrix3d rolled =
        Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    return geometry::RigidTransform::from_matrix(level * rolled, {place.x(), place.y(), height});
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
  const WalkOptions& options_;
  RandomStream none_{0};
  std::array<Wandering, 3> shifts_{Wandering(none_, 0), Wandering(none_, 0), Wandering(none_, 0)};
  std::array<Wandering, 3> turns_{Wandering(none_, 0), Wandering(none_, 0), Wandering(none_, 0)};
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
  ROOMWISE_CHECK_OK(options.validate());
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
    pose.world_from_camera_open = camera.pose_at(time_s - kShutter / 2);
    pose.world_from_camera_close = camera.pose_at(time_s + kShutter / 2);
    const Eigen::Vector3d& camera_place = pose.world_from_camera.translation;
    pose.room = room_at(home, camera_place.head<2>(), camera_place.z() - options.camera_height_m);
  }
  return poses;
}

}  // namespace roomwise::simulation
