#pragma once

#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/scene/keyframe.h"

namespace roomwise::scene {

// A measurement of one key-frame's pose relative to another's. The error that the optimisation
// squares is g2o's for EDGE_SE3:QUAT: with
// d = from_from_to^-1 * world_from_from^-1 * world_from_to,
//   e = (translation of d in m, vector part of d's unit quaternion, taken with w >= 0).
struct PoseGraphEdge {
  KeyframeId from = 0;
  KeyframeId to = 0;
  geometry::RigidTransform from_from_to;
  // Omega: inverse covariance of e, in the order (x, y, z, qx, qy, qz). Symmetric, positive
  // semi-definite.
  geometry::Matrix6d information = geometry::Matrix6d::Identity();
  // A loop closure may be wrong and gets a robust kernel; a step of the odometry does not.
  bool is_robust = false;
  // By the device's own motion, and not by what pictures show. It is one of the loops, too: it may
  // be wrong.
  bool is_device_motion = false;
};

}  // namespace roomwise::scene
