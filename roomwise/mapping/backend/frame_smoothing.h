#pragma once

#include <optional>
#include <span>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/base/timestamp.h"
#include "roomwise/geometry/rigid_transform.h"

namespace roomwise::mapping {

struct SmoothingOptions {
  // How far a frame's measured place usually is from where it was ...
  double place_sigma_m = 0.005;
  double place_sigma_rad = 0.005;
  // ... beyond so many sigmas it counts less and less (Cauchy's kernel): it may be wrong.
  double kernel_sigmas = 1.5;
  // How hard the camera is usually sped up, as a multiple of what the held frames show: their
  // median.
  double acceleration_share = 2;

  [[nodiscard]] Expected<void> validate() const;
};

// A frame of a walk and where it was found to be.
struct PlacedFrame {
  TimestampNs timestamp_ns = 0;
  std::optional<geometry::RigidTransform> world_from_camera;
  bool is_fixed = false;  // better known than the others: it stays where it is
};

// Moves frames to where they agree as well as they can with their measured places and with a motion
// that cannot jump: each three frames in a row say how the camera was sped up, and the held frames,
// which are further apart, how hard that usually is. Where frames are far apart in time it says
// next to nothing, and nothing moves; nor across frames without a place, nor where fewer than ten
// held frames tell the acceleration. Frames must be in the order of time.
void smooth_frames(std::span<PlacedFrame> frames, const SmoothingOptions& options = {});

}  // namespace roomwise::mapping
