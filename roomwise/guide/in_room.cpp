#include "roomwise/guide/in_room.h"

#include <cmath>
#include <numbers>

namespace roomwise::guide {

bool is_well_inside(const HomeMap& map, const std::string& room,
                    const Eigen::Vector2d& place_gravity) {
  constexpr double kBody_m = 0.25;
  constexpr int kDirections = 12;
  if (map.room_at(place_gravity) != room) return false;
  for (int i = 0; i < kDirections; ++i) {
    const double heading = 2 * std::numbers::pi * i / kDirections;
    const Eigen::Vector2d beside =
        place_gravity + kBody_m * Eigen::Vector2d(std::cos(heading), std::sin(heading));
    // Walls and things are of no room.
    const auto other = map.room_at(beside);
    if (other && *other != room) return false;
  }
  return true;
}

}  // namespace roomwise::guide
