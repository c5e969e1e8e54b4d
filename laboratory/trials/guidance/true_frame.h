#pragma once

#include <Eigen/Core>

#include "laboratory/trials/guidance/leader.h"
#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/service/protocol/messages.h"

namespace roomwise::trials {

// How a map lies over the home that it was made of. Upright, one storey.
struct TrueFrame {
  geometry::RigidTransform truth_from_gravity;

  [[nodiscard]] Eigen::Vector2d to_truth(const Eigen::Vector2d& place_gravity) const;
  [[nodiscard]] Eigen::Vector2d to_map(const Eigen::Vector2d& place_truth) const;
  // Of a direction over the floor, rad.
  [[nodiscard]] double heading_on_map(double heading_truth_rad) const;
};

// Notes how far a place that the computer told is from where the camera was.
void add_error(const service::SeenPosition& told, const geometry::RigidTransform& truth_from_camera,
               const TrueFrame& frame, Sightings& sightings);

}  // namespace roomwise::trials
