#pragma once

#include <Eigen/Core>
#include <optional>

#include "laboratory/simulation/recording/simulate_recording.h"
#include "laboratory/simulation/walk/carried_camera.h"
#include "roomwise/base/thread_pool.h"
#include "roomwise/image/rgbd_frame.h"

namespace roomwise::trials {

// A camera on somebody's chest, and what it is.
struct ChestCameraOptions {
  geometry::PinholeCamera camera = simulation::SimulationOptions::default_camera();
  simulation::SensorOptions sensor = {};
  double height_m = 1.3;  // over the floor
  double ahead_m = 0.1;   // of the body's middle
  double down_rad = 0.17;
  double jitter = 1;  // 0: it neither bobs nor shakes
  // A phone's, of which nobody knows more than its size, and which measures no depth; else a
  // wearable's, calibrated, with depth.
  bool is_phone = false;

  [[nodiscard]] Expected<void> validate() const;
};

// Takes pictures of a home where somebody walks, as the sensor gives them.
class ChestCamera {
 public:
  // `renderer` and `pool` must outlive it.
  [[nodiscard]] static Expected<ChestCamera> create(const ChestCameraOptions& options,
                                                    const simulation::Renderer& renderer,
                                                    ThreadPool& pool, std::uint64_t seed);

  // Where its bearer is now; called with each of their steps, from which their pace is known.
  void carry(double now_s, const Eigen::Vector2d& place, double heading_rad);

  struct Picture {
    geometry::RigidTransform world_from_camera;  // in truth
    image::RgbdFrame frame;
  };
  [[nodiscard]] Picture take();
  [[nodiscard]] geometry::RigidTransform world_from_camera() const { return pose_after(0); }

 private:
  ChestCamera(const ChestCameraOptions& options, const simulation::Renderer& renderer,
              simulation::Sensor sensor, ThreadPool& pool, std::uint64_t seed);
  // So long after now.
  [[nodiscard]] geometry::RigidTransform pose_after(double seconds) const;

  ChestCameraOptions options_;
  const simulation::Renderer& renderer_;
  simulation::Sensor sensor_;
  simulation::ExposureControl exposure_;
  simulation::CarriedCamera carried_;
  ThreadPool& pool_;
  struct Bearer {
    double at_s = 0;
    Eigen::Vector2d place = Eigen::Vector2d::Zero();
    double heading_rad = 0;
  };
  Bearer bearer_;
  Eigen::Vector2d velocity_m_s_ = Eigen::Vector2d::Zero();
  double turning_rad_s_ = 0;
  bool is_carried_ = false;
  std::uint64_t taken_ = 0;
};

}  // namespace roomwise::trials
