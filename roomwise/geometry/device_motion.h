#pragma once

#include <Eigen/Core>
#include <optional>

#include "roomwise/geometry/rigid_transform.h"

namespace roomwise::geometry {

// What a device knew of its camera's motion when it took a picture (ARKit, ARCore, visual-inertial
// or wheel odometry), without what was found out later.
struct DeviceMotion {
  // Camera: x right, y down, z forward; the world as the device had it. Between two pictures it
  // drifts, and it may jump.
  RigidTransform world_from_camera;
  // The direction up in the camera's frame, unit length, where the device feels gravity.
  std::optional<Eigen::Vector3d> up_camera = std::nullopt;
};

}  // namespace roomwise::geometry
