#pragma once

#include <Eigen/Core>
#include <span>

#include "roomwise/evaluation/trajectory_error.h"

namespace roomwise::evaluation {

struct CloudError {
  ErrorStatistics distance_m;             // of the points that have a surface near them
  std::size_t points = 0;                 // of the estimate
  std::size_t far_points = 0;             // with no surface within the greatest distance
  double within_1cm = 0, within_5cm = 0;  // shares of all points
};

// How far a map's points lie from the true surfaces, which are given as points too: to the nearest
// of them, so that their spacing bounds what can be measured. Both in one frame, m. Fails where one
// of the two is empty or the distance is not positive.
[[nodiscard]] Expected<CloudError> cloud_error(std::span<const Eigen::Vector3f> truth,
                                               std::span<const Eigen::Vector3f> estimate,
                                               double most_distance_m = 0.5);

}  // namespace roomwise::evaluation
