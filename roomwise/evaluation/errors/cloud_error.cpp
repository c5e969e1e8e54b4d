#include "roomwise/evaluation/errors/cloud_error.h"

#include <cmath>
#include <utility>
#include <vector>

namespace roomwise::evaluation {

Expected<CloudError> cloud_error(std::span<const double> distances_m) {
  if (distances_m.empty()) return fail("the map has no point to compare");
  constexpr double kWithin1cm = 0.01;
  constexpr double kWithin5cm = 0.05;
  CloudError error;
  error.points = distances_m.size();
  std::vector<double> near;
  std::size_t within_1cm = 0, within_5cm = 0;
  for (const double distance_m : distances_m) {
    if (std::isfinite(distance_m)) near.push_back(distance_m);
    within_1cm += distance_m <= kWithin1cm ? 1 : 0;
    within_5cm += distance_m <= kWithin5cm ? 1 : 0;
  }
  const auto count = static_cast<double>(distances_m.size());
  error.far_points = distances_m.size() - near.size();
  error.within_1cm = static_cast<double>(within_1cm) / count;
  error.within_5cm = static_cast<double>(within_5cm) / count;
  if (!near.empty()) error.distance_m = ErrorStatistics::of(std::move(near));
  return error;
}

}  // namespace roomwise::evaluation
