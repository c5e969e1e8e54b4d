#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "laboratory/simulation/render/renderer.h"
#include "laboratory/simulation/walk/walk.h"
#include "roomwise/base/thread_pool.h"
#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/image/rgbd_frame.h"

namespace roomwise::simulation {

// What the sensor spoils, each by itself. As it is by default it behaves like a first Kinect or an
// Asus Xtion.
struct SensorOptions {
  std::uint64_t seed = 0;

  // Colour.
  bool auto_exposure = true;  // follows the scene's brightness over some frames
  double exposure = 1;        // without it: radiance times this is 1 at the sensor's white
  bool exposure_errors = true;
  bool auto_white_balance = true;  // follows the light's colour, and leaves a part of it
  bool white_balance_errors = true;
  bool soft_shoulder = true;  // highlights fade to white; else they are cut
  bool motion_blur = true;
  bool color_noise = true;
  // Scenes of this mean radiance (cd/m^2) are exposed without amplification; darker ones are
  // amplified, with their noise, at most this many times, and stay dark beyond.
  double unamplified_radiance = 30;
  double max_amplification = 16;

  // Depth.
  bool depth_noise = true;
  // Standard deviation at 1 m; it grows with the square of the distance. Together with the
  // quantisation this gives the 1.4 mm that Khoshelham and Elberink (Sensors 12, 2012) measured.
  double depth_noise_m = 0.0011;
  bool depth_quantization = true;  // in steps of 1/8 px of disparity
  bool projector_shadow = true;    // what the pattern's projector does not see has no depth
  bool lost_surfaces = true;       // shiny, dark or grazing: the pattern is not seen
  bool edge_jitter = true;         // the outlines of things are ragged
  bool limited_range = true;
  double nearest_m = 0.5, farthest_m = 5;

  // Everything off: exact depth (but for the rounding to depth units), colour at `exposure`.
  [[nodiscard]] static SensorOptions ideal();
  [[nodiscard]] Expected<void> validate() const;
};

// How the colour of one frame is developed.
struct ColorSettings {
  double exposure = 1;       // from radiance to the sensor's 0 to 1
  double amplification = 1;  // of the noise, too
  Eigen::Vector3f balance = Eigen::Vector3f::Ones();
};

// The camera's control of exposure and white balance. Its state goes from frame to frame, in the
// order of the walk; the rest of the sensor sees each frame by itself.
class ExposureControl {
 public:
  explicit ExposureControl(const SensorOptions& options) : options_(options) {}

  // Meters the next frame and moves the state towards what it calls for.
  ColorSettings next(const RenderedFrame& frame, TimestampNs timestamp_ns, std::uint64_t index);

 private:
  void drift(double elapsed_s, std::uint64_t index);

  SensorOptions options_;
  bool has_started_ = false;
  TimestampNs last_timestamp_ns_ = 0;
  double exposure_ev_ = 0, exposure_error_ev_ = 0;     // powers of two
  Eigen::Vector2d balance_ = Eigen::Vector2d::Zero();  // of red and blue against green, log
  Eigen::Vector2d balance_error_ = Eigen::Vector2d::Zero();
};

// Makes of what the camera would see what its sensor gives. Same bits at any number of threads.
class Sensor {
 public:
  // Fails where the camera or the options make no sense.
  [[nodiscard]] static Expected<Sensor> create(const geometry::PinholeCamera& camera,
                                               const SensorOptions& options);

  // The frame of a walk's pose. Its images must be of the camera's size. A pure function of its
  // arguments: frames may be taken in any order.
  [[nodiscard]] image::RgbdFrame capture(const RenderedFrame& frame, const WalkPose& pose,
                                         std::uint64_t index, const ColorSettings& settings,
                                         ThreadPool& pool) const;

 private:
  Sensor(const geometry::PinholeCamera& camera, const SensorOptions& options);

  geometry::PinholeCamera camera_;
  SensorOptions options_;
  image::Image<Eigen::Vector2f> rays_;       // of every pixel, at depth 1
  std::vector<std::uint8_t> tone_of_light_;  // the tone curve by steps of exposed light
};

}  // namespace roomwise::simulation
