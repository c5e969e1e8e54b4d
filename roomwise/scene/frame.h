#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "roomwise/base/timestamp.h"
#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/scene/keyframe.h"

namespace roomwise::scene {

// Where a frame was taken: relative to a key-frame, whose pose may still change.
struct FramePlace {
  KeyframeId keyframe = 0;
  geometry::RigidTransform keyframe_from_camera;
};

// A frame of a walk that mapping has looked at.
struct Frame {
  std::uint64_t index = 0;  // RgbdFrame::index
  TimestampNs timestamp_ns = 0;
  std::optional<FramePlace> place;
  std::string no_pose_reason;  // the motion's outcome, where there is no place
};

}  // namespace roomwise::scene
