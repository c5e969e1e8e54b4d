#include "laboratory/trials/guidance/chest_camera.h"

#include <cmath>

#include "laboratory/trials/guidance/leader.h"
#include "roomwise/guide/way/legs.h"

namespace roomwise::trials {
namespace {

simulation::SensorOptions sensor_of(const ChestCameraOptions& options, std::uint64_t seed) {
  simulation::SensorOptions sensor = options.sensor;
  sensor.seed = seed;
  return sensor;
}

simulation::WalkOptions bearing_of(const ChestCameraOptions& options, std::uint64_t seed) {
  simulation::WalkOptions walk;
  walk.seed = seed;
  walk.camera_height_m = options.height_m;
  walk.jitter = options.jitter;
  return walk;
}

}  // namespace

Expected<void> ChestCameraOptions::validate() const {
  ROOMWISE_RETURN_IF_ERROR(camera.validate());
  ROOMWISE_RETURN_IF_ERROR(sensor.validate());
  ROOMWISE_RETURN_IF_ERROR(bearing_of(*this, 0).validate());
  constexpr double kHalfBody_m = 0.5;
  if (!(ahead_m >= 0 && ahead_m <= kHalfBody_m)) {
    return fail("ahead_m is {}; expected 0 to {}", ahead_m, kHalfBody_m);
  }
  if (!(std::abs(down_rad) < 1)) return fail("down_rad is {}; expected -1 to 1", down_rad);
  return {};
}

Expected<ChestCamera> ChestCamera::create(const ChestCameraOptions& options,
                                          const simulation::Renderer& renderer, ThreadPool& pool,
                                          std::uint64_t seed) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  ROOMWISE_TRY(simulation::Sensor sensor,
               simulation::Sensor::create(options.camera, sensor_of(options, seed)));
  return ChestCamera(options, renderer, std::move(sensor), pool, seed);
}

ChestCamera::ChestCamera(const ChestCameraOptions& options, const simulation::Renderer& renderer,
                         simulation::Sensor sensor, ThreadPool& pool, std::uint64_t seed)
    : options_(options),
      renderer_(renderer),
      sensor_(std::move(sensor)),
      exposure_(sensor_of(options, seed)),
      carried_(bearing_of(options, seed)),
      pool_(pool) {}

void ChestCamera::carry(double now_s, const Eigen::Vector2d& place, double heading_rad) {
  const double elapsed_s = now_s - bearer_.at_s;
  if (is_carried_ && elapsed_s > 0) {
    velocity_m_s_ = (place - bearer_.place) / elapsed_s;
    turning_rad_s_ = guide::turn_rad(bearer_.heading_rad, heading_rad) / elapsed_s;
  }
  is_carried_ = true;
  bearer_ = {now_s, place, heading_rad};
}

geometry::RigidTransform ChestCamera::pose_after(double seconds) const {
  simulation::BodyState chest;
  chest.heading_rad = bearer_.heading_rad + seconds * turning_rad_s_;
  chest.place =
      bearer_.place + seconds * velocity_m_s_ +
      options_.ahead_m * Eigen::Vector2d(std::cos(chest.heading_rad), std::sin(chest.heading_rad));
  chest.down_rad = options_.down_rad;
  chest.speed_m_s = velocity_m_s_.norm();
  return carried_.pose(chest, bearer_.at_s + seconds);
}

ChestCamera::Picture ChestCamera::take() {
  simulation::WalkPose pose;
  pose.timestamp_ns = trial_ns(bearer_.at_s);
  pose.world_from_camera = pose_after(0);
  pose.world_from_camera_open = pose_after(-simulation::kShutter_s / 2);
  pose.world_from_camera_close = pose_after(simulation::kShutter_s / 2);
  const simulation::RenderedFrame seen =
      renderer_.render(options_.camera, pose.world_from_camera, pool_);
  const simulation::ColorSettings settings = exposure_.next(seen, pose.timestamp_ns, taken_);
  return {pose.world_from_camera, sensor_.capture(seen, pose, taken_++, settings, pool_)};
}

}  // namespace roomwise::trials
