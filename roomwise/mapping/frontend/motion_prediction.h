#pragma once

#include <optional>

#include "roomwise/base/timestamp.h"
#include "roomwise/motion/view_alignment.h"

namespace roomwise::mapping {

// Where a camera was, relative to some key-frame, and when.
struct StampedMotion {
  geometry::RigidTransform keyframe_from_camera;
  TimestampNs timestamp_ns = 0;
};

// Where it is later if it goes on as it moved last (from `older` to `newer`, where both are known),
// give or take what a person who holds it does.
[[nodiscard]] motion::PosePrior predict_motion(const std::optional<StampedMotion>& older,
                                               const StampedMotion& newer, TimestampNs later_ns);

// How far the place of that is off after so long, one sigma on each axis, m.
[[nodiscard]] double walk_sigma_m(double ahead_s);

}  // namespace roomwise::mapping
