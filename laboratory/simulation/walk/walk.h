#pragma once

#include <cstdint>
#include <vector>

#include "laboratory/simulation/home/home_model.h"
#include "roomwise/base/expected.h"
#include "roomwise/base/timestamp.h"
#include "roomwise/geometry/rigid_transform.h"

namespace roomwise::simulation {

struct WalkOptions {
  std::uint64_t seed = 0;
  double frames_per_second = 5;
  double camera_height_m = 1.4;  // 1.2 to 1.6: hand-held or chest-worn
  double walking_speed_m_s = 0.6;
  double max_turning_rad_s = 0.8;  // but for the fast turns
  double jitter = 1;               // 0: no bob, no jitter of the hand
  bool fast_turns = true;
  std::vector<std::string> rooms;  // to visit, by name, in this order; empty: all, then back
  std::size_t max_frames = 0;      // 0: as many as the walk needs

  [[nodiscard]] Expected<void> validate() const;
};

struct WalkPose {
  TimestampNs timestamp_ns = 0;
  geometry::RigidTransform world_from_camera;  // camera: x right, y down, z forward
  // Where the camera was while the shutter was open, for motion blur: at its opening and closing.
  geometry::RigidTransform world_from_camera_open, world_from_camera_close;
  std::size_t room = 0;  // in which the camera is, index into HomeModel::rooms
};

// A person's walk through the home: through the free space, looking around in every room, coming
// back to close loops. Fails where a room cannot be reached.
[[nodiscard]] Expected<std::vector<WalkPose>> plan_walk(const HomeModel& home,
                                                        const WalkOptions& options);

}  // namespace roomwise::simulation
