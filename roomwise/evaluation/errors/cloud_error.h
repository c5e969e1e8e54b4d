#pragma once

#include <span>

#include "roomwise/evaluation/errors/trajectory_error.h"

namespace roomwise::evaluation {

struct CloudError {
  ErrorStatistics distance_m;             // of the points that have a surface near them
  std::size_t points = 0;                 // of the map
  std::size_t far_points = 0;             // without a surface within the greatest distance
  double within_1cm = 0, within_5cm = 0;  // shares of all points
};

// How far a map's points lie from the true surfaces, by each point's distance to the nearest, m;
// infinity where there is none near it. Fails where there is no point.
[[nodiscard]] Expected<CloudError> cloud_error(std::span<const double> distances_m);

}  // namespace roomwise::evaluation
