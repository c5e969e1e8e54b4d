#pragma once

#include <optional>

#include "roomwise/mapping/frontend/keyframe.h"
#include "roomwise/mapping/graph/pose_graph.h"
#include "roomwise/motion/view_alignment.h"
#include "roomwise/scene/frame.h"

namespace roomwise::mapping {

// A moment of a device's own motion: where it believed itself, and what it had travelled since the
// recording began.
struct DeviceMark {
  geometry::RigidTransform world_from_camera;  // the device's world
  double path_m = 0;
  double turned_rad = 0;
  double silent_s = 0;  // in which it told nothing
  int breaks = 0;       // over which it says nothing: it jumped, or was silent for long
};

// How a device moved from one moment to another, with an honest covariance: it errs by a part of
// the way, of the turns and of the time in which it was silent. Nothing where a break lies between.
[[nodiscard]] std::optional<motion::PosePrior> device_step(const DeviceMark& from,
                                                           const DeviceMark& to);

// The same between two key-frames, as an edge that may turn out wrong.
[[nodiscard]] PoseGraphEdge edge_from_device(KeyframeId from, KeyframeId to,
                                             const motion::PosePrior& step);

// Whether a device says that it moved as nobody moves it.
[[nodiscard]] bool is_device_jump(const geometry::RigidTransform& step, double duration_s);

// Adds up the way that a device travelled, one frame after the other.
class DeviceOdometry {
 public:
  // The next frame's; nothing where its device tells nothing. Between the frame before and one
  // whose motion was dropped there is a break.
  [[nodiscard]] std::optional<DeviceMark> mark(const scene::Frame& next) const;
  // Whether the device says that it moved as nobody moves it, since the frame before.
  [[nodiscard]] bool jumps_to(const scene::Frame& next) const;
  // The frame is next no more.
  void pass(const scene::Frame& frame);

 private:
  std::optional<DeviceMark> last_;
  TimestampNs last_ns_ = 0;
  bool is_silent_ = false;  // since then
};

}  // namespace roomwise::mapping
