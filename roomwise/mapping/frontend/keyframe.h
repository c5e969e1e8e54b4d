#pragma once

#include "roomwise/motion/frame_measurements.h"
#include "roomwise/scene/keyframe.h"

namespace roomwise::mapping {

using scene::KeyframeId;
using scene::KeyframeStamp;

// A key-frame and what was measured in its images.
struct Keyframe : KeyframeStamp {
  motion::FrameMeasurements measurements;
};

}  // namespace roomwise::mapping
