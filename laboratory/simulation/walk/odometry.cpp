#include "laboratory/simulation/walk/odometry.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "roomwise/base/random.h"

namespace roomwise::simulation {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;
using recording::StampedPose;

constexpr double kSteadyPath_m = 5;  // after which it turns another way
// Turning by d / L rad a metre for L metres leads d L / 2 aside.
constexpr double kTurn_rad_m = 2 / (2 * kSteadyPath_m);
constexpr double kNoise_m = 0.001;
constexpr double kNoise_rad = 0.0005;
constexpr double kShortestDropout_s = 1, kLongestDropout_s = 2;
constexpr double kMinJump_m = 0.1, kMaxJump_m = 0.5, kMaxJump_rad = 0.2;

RigidTransform about_up(double angle_rad, const Vector3d& translation = Vector3d::Zero()) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, Vector3d::UnitZ())), translation};
}

// What is wrong with the device's idea of the way, step by step.
class Drift {
 public:
  explicit Drift(const OdometryOptions& options)
      : options_(options), random_(options.seed, {0x6472696674}) {
    scale_ = 1 + options.drift * std::numbers::sqrt2 / 2 * random_.normal();
    sample_turning();
  }

  // device_from_device of a true step.
  RigidTransform of(const RigidTransform& step) {
    const double length_m = step.distance_m();
    path_m_ += length_m;
    if (path_m_ > kSteadyPath_m) sample_turning();
    RigidTransform drifted = step;
    drifted.translation *= scale_;
    turned_rad_ = turning_rad_m_ * length_m;
    return drifted;
  }
  [[nodiscard]] double turned_rad() const { return turned_rad_; }
  RigidTransform noise() {
    const auto three = [&] {
      return Vector3d(random_.normal(), random_.normal(), random_.normal());
    };
    geometry::Vector6d twist;
    twist << kNoise_rad * three(), kNoise_m * three();
    return RigidTransform::exp(twist);
  }

 private:
  void sample_turning() {
    path_m_ = 0;
    turning_rad_m_ = options_.drift * std::numbers::sqrt2 / 2 * kTurn_rad_m * random_.normal();
  }

  const OdometryOptions& options_;
  RandomStream random_;
  double scale_ = 1, turning_rad_m_ = 0, path_m_ = 0, turned_rad_ = 0;
};

RigidTransform jump(RandomStream& random) {
  const double length_m = random.between(kMinJump_m, kMaxJump_m);
  const double towards_rad = random.between(0, 2 * std::numbers::pi);
  return about_up(random.between(-kMaxJump_rad, kMaxJump_rad),
                  length_m * Vector3d(std::cos(towards_rad), std::sin(towards_rad), 0));
}

// Frames, none of them the first, at which something happens.
std::set<std::size_t> sample_frames(std::size_t frames, int count, RandomStream& random) {
  std::set<std::size_t> drawn;
  const auto most = std::min<std::size_t>(static_cast<std::size_t>(count), (frames - 1) / 2);
  while (drawn.size() < most) drawn.insert(1 + random.index(frames - 1));
  return drawn;
}

// Times (from, to) without a pose.
std::vector<std::pair<TimestampNs, TimestampNs>> sample_dropouts(std::span<const StampedPose> truth,
                                                                 int count, RandomStream& random) {
  std::vector<std::pair<TimestampNs, TimestampNs>> dropouts;
  for (const std::size_t at : sample_frames(truth.size(), count, random)) {
    const double seconds = random.between(kShortestDropout_s, kLongestDropout_s);
    const TimestampNs from = truth[at].timestamp_ns;
    dropouts.emplace_back(from, from + static_cast<TimestampNs>(seconds / kSecondsPerNs));
  }
  return dropouts;
}

}  // namespace

Expected<void> OdometryOptions::validate() const {
  if (!(drift >= 0 && drift <= 0.5)) return fail("drift = {} must be from 0 to 0.5", drift);
  if (jumps < 0 || dropouts < 0)
    return fail("jumps = {} and dropouts = {} must not be negative", jumps, dropouts);
  return {};
}

recording::Odometry simulate_odometry(std::span<const StampedPose> truth,
                                      const OdometryOptions& options) {
  recording::Odometry odometry;
  odometry.up = Vector3d::UnitZ();
  if (truth.empty()) return odometry;
  RandomStream random(options.seed, {0x6a756d70});
  const auto jumps = sample_frames(truth.size(), options.jumps, random);
  const auto dropouts = sample_dropouts(truth, options.dropouts, random);
  Drift drift(options);
  // The first pose, turned and moved: its world is not the home's.
  RigidTransform device_from_camera =
      about_up(random.between(-3, 3), {1, 2, 0}) * truth[0].world_from_camera;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (i > 0) {
      device_from_camera = device_from_camera * drift.of(truth[i - 1].world_from_camera.inverse() *
                                                         truth[i].world_from_camera);
      // About where the camera stands.
      device_from_camera.rotation =
          about_up(drift.turned_rad()).rotation * device_from_camera.rotation;
    }
    if (jumps.contains(i)) {
      const RigidTransform moved = jump(random);
      device_from_camera.rotation = moved.rotation * device_from_camera.rotation;
      device_from_camera.translation += moved.translation;
    }
    const TimestampNs now = truth[i].timestamp_ns;
    const RigidTransform told = device_from_camera * drift.noise();
    const bool is_silent = std::ranges::any_of(
        dropouts, [&](const auto& span) { return now >= span.first && now < span.second; });
    if (!is_silent) odometry.poses.push_back({now, told});
  }
  return odometry;
}

}  // namespace roomwise::simulation
