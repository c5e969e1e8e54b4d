#pragma once

#include <cstdint>

#include "roomwise/base/timestamp.h"
#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/motion/frame_measurements.h"

namespace roomwise::mapping {

using KeyframeId = std::uint64_t;  // 0, 1, 2, ... in the order of time

// Which frame of the walk a key-frame is.
struct KeyframeStamp {
  KeyframeId id = 0;
  std::uint64_t frame_index = 0;  // RgbdFrame::index
  TimestampNs timestamp_ns = 0;
};

// A frame that the map keeps. Everything that is seen from it (points, objects) is stored relative
// to it, and follows when optimisation moves it.
struct Keyframe {
  KeyframeId id = 0;
  std::uint64_t frame_index = 0;  // RgbdFrame::index
  TimestampNs timestamp_ns = 0;
  motion::FrameMeasurements measurements;
};

}  // namespace roomwise::mapping
