#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "roomwise/base/timestamp.h"
#include "roomwise/geometry/device_motion.h"
#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/scene/keyframe.h"

namespace roomwise::scene {

// Where a frame was taken: relative to a key-frame, whose pose may still change.
struct FramePlace {
  KeyframeId keyframe = 0;
  geometry::RigidTransform keyframe_from_camera;
};

// What mapping made of the device's own motion up to a frame, from the one before.
enum class MotionUse {
  kTaken,    // expected, and not contradicted by the pictures
  kDropped,  // the pictures say otherwise, or nobody moves so fast: it jumped, or does not fit
  kAlone,    // the pictures say nothing or leave it open: the frame's place is from it alone
};

struct FrameMotion {
  geometry::DeviceMotion device;
  MotionUse use = MotionUse::kTaken;
};

// A frame of a walk that mapping has looked at.
struct Frame {
  std::uint64_t index = 0;  // RgbdFrame::index
  TimestampNs timestamp_ns = 0;
  std::optional<FramePlace> place;
  std::string no_pose_reason;  // the motion's outcome, where there is no place
  std::optional<FrameMotion> motion = std::nullopt;  // where its device tells it
};

}  // namespace roomwise::scene
