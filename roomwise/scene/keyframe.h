#pragma once

#include <cstdint>

#include "roomwise/base/timestamp.h"
#include "roomwise/geometry/rigid_transform.h"

// What a mapped home is made of, as plain values: frames, key-frames and the pose graph between
// them, things, rooms, visits. They are computed in the modules above and stored by home/.
namespace roomwise::scene {

using KeyframeId = std::uint64_t;  // 0, 1, 2, ... in the order of time

// Which frame of the walk a key-frame is. A key-frame is a frame that the map keeps: everything
// that is seen from it (points, objects) is stored relative to it, and follows when optimisation
// moves it.
struct KeyframeStamp {
  KeyframeId id = 0;
  std::uint64_t frame_index = 0;  // RgbdFrame::index
  TimestampNs timestamp_ns = 0;
};

struct KeyframePose {
  geometry::RigidTransform world_from_keyframe;
  // Poses of one connected component of the map share a world; the largest is 0.
  std::uint64_t component = 0;
};

}  // namespace roomwise::scene
