#pragma once

#include <cstdint>
#include <span>

#include "roomwise/recording/odometry_file.h"

namespace roomwise::simulation {

// How a device's own odometry errs: a phone's, visual and inertial together.
struct OdometryOptions {
  std::uint64_t seed = 0;
  double drift = 0.01;  // of the way, RMS over some ten metres: 0.005 to 0.02 for phones
  int jumps = 0;        // it finds itself again, 0.1 to 0.5 m and up to 0.2 rad from where it was
  int dropouts = 0;     // 1 to 2 s without a pose

  [[nodiscard]] Expected<void> validate() const;
};

// What such a device says along a walk, in a level world of its own (z up): half of the drift is a
// wrong scale, half a slow turning; besides a millimetre and half a milliradian of noise at each
// pose. Same options and walk, same odometry.
[[nodiscard]] recording::Odometry simulate_odometry(std::span<const recording::StampedPose> truth,
                                                    const OdometryOptions& options);

}  // namespace roomwise::simulation
