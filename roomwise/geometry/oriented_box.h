#pragma once

#include <Eigen/Core>

#include "roomwise/geometry/rigid_transform.h"

namespace roomwise::geometry {

// A box in any orientation: the box frame has its origin in the middle and the axes along the
// edges.
struct OrientedBox {
  RigidTransform world_from_box;
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  // edge lengths along x, y, z of the box frame

  [[nodiscard]] const Eigen::Vector3d& center() const { return world_from_box.translation; }
  // To the nearest point of the box, m; 0 inside.
  [[nodiscard]] double distance_m(const Eigen::Vector3d& point_world) const {
    const Eigen::Vector3d point_box = world_from_box.inverse() * point_world;
    return (point_box.cwiseAbs() - 0.5 * size_m).cwiseMax(0.0).norm();
  }
};

}  // namespace roomwise::geometry
