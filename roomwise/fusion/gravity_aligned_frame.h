#pragma once

#include <span>

#include "roomwise/fusion/piecewise_mesh.h"
#include "roomwise/fusion/storeys.h"
#include "roomwise/geometry/rigid_transform.h"

namespace roomwise::fusion {

// A frame for people and robots: z points up, z = 0 is the floor, the origin lies under the world's
// (the first camera), and x is the direction in which the first camera looked, made level.
struct GravityAlignedFrame {
  geometry::RigidTransform gravity_from_world;
  // Whether a floor was found. Without one z = 0 is the height of the first camera.
  bool has_floor = false;
  // Without level surfaces up is as devices feel it, or where none does the mean up of the cameras.
  bool has_up = false;
  // Of a home of several; else z = 0 is the one floor, and the plan is this frame.
  Storeys storeys = {};

  // A point of the world on the plan, z over the floor of its storey.
  [[nodiscard]] Eigen::Vector3d on_plan(const Eigen::Vector3d& point_world) const {
    return storeys.plan_from_gravity(gravity_from_world * point_world);
  }
  [[nodiscard]] geometry::RigidTransform on_plan(
      const geometry::RigidTransform& world_from_camera) const {
    geometry::RigidTransform plan_from_camera = gravity_from_world * world_from_camera;
    plan_from_camera.translation = storeys.plan_from_gravity(plan_from_camera.translation);
    return plan_from_camera;
  }
  [[nodiscard]] Eigen::Vector3d world_from_plan(const Eigen::Vector3d& point_plan) const {
    return gravity_from_world.inverse() * storeys.gravity_from_plan(point_plan);
  }
};

// By the normals of the map's surface, which vote for the direction up (see UpDirectionEstimator),
// and its floor: the lowest level that holds at least a third as much upward surface as the fullest
// one below the cameras. A plane through the floor then corrects the direction, since half a degree
// would be 9 cm at the other end of a flat. `gravity_up_world` is up where devices feel it. Fails
// where the mesh cannot be read.
[[nodiscard]] Expected<GravityAlignedFrame> find_gravity_aligned_frame(
    const PiecewiseMesh& mesh_world, std::span<const geometry::RigidTransform> world_from_cameras,
    std::span<const Eigen::Vector3d> gravity_up_world = {});

}  // namespace roomwise::fusion
