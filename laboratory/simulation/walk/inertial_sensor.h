#pragma once

#include <cstdint>
#include <span>

#include "roomwise/geometry/inertial_track.h"
#include "roomwise/recording/trajectory_file.h"

namespace roomwise::simulation {

// How an inertial sensor errs. The defaults are those of a phone's part, Bosch's BMI160, by its
// data sheet: noise densities and offsets as they are told, a bias that follows the temperature by
// a Kelvin a minute.
struct InertialSensorOptions {
  std::uint64_t seed = 0;
  double rate_hz = 200;
  double turning_noise_rad_sqrt_s = 1.2e-4;   // density: 0.007 degrees a second / sqrt(Hz)
  double turning_bias_rad_s = 0.052;          // sigma of each axis as it is switched on: 3 degrees
  double turning_walk_rad_s_sqrt_s = 1.1e-4;  // of the bias: 0.05 degrees a second in a minute
  double turning_scale = 0.03;                // sigma
  double force_noise_m_s2_sqrt_s = 1.8e-3;    // density: 180 ug / sqrt(Hz)
  double force_bias_m_s2 = 0.39;              // sigma of each axis: 40 mg
  double force_walk_m_s2_sqrt_s = 1.3e-3;     // of the bias: 1 mg in a minute

  [[nodiscard]] Expected<void> validate() const;
};

// What such a sensor feels in the camera along a walk in a world whose z is up, from the first pose
// to the last: between poses the place runs along a natural cubic spline, and the camera turns
// evenly. Fewer than two poses are felt as nothing. Same options and walk, same samples.
[[nodiscard]] geometry::InertialTrack simulate_inertial_sensor(
    std::span<const recording::StampedPose> truth, const InertialSensorOptions& options);

}  // namespace roomwise::simulation
