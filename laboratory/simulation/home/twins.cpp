#include "laboratory/simulation/home/twins.h"

#include <limits>
#include <utility>

#include "laboratory/simulation/home/finishes.h"

namespace roomwise::simulation {

HomeModel with_other_finishes(HomeModel plan, std::uint64_t seed) {
  for (std::size_t room = 0; room < plan.rooms.size(); ++room)
    finish_room(seed, room, plan.rooms[room]);
  return plan;
}

HomeModel mirrored(HomeModel plan) {
  double least = std::numeric_limits<double>::max(), most = std::numeric_limits<double>::lowest();
  for (const Room& room : plan.rooms) {
    least = std::min(least, room.interior.min.x());
    most = std::max(most, room.interior.max.x());
  }
  const auto mirror = [&](double& x) { x = least + most - x; };
  for (Room& room : plan.rooms) {
    mirror(room.interior.min.x());
    mirror(room.interior.max.x());
    std::swap(room.interior.min.x(), room.interior.max.x());
  }
  for (Door& door : plan.doors) {
    mirror(door.opening.center.x());
    bool& side = door.opening.along_x ? door.hinge_at_min : door.opens_to_positive;
    side = !side;
  }
  for (Window& window : plan.windows) {
    mirror(window.opening.center.x());
    if (!window.opening.along_x) window.outside_is_positive = !window.outside_is_positive;
  }
  return plan;
}

}  // namespace roomwise::simulation
