#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/fusion/floor_grid.h"
#include "roomwise/fusion/storeys.h"
#include "roomwise/rooms/layout/room_layout.h"

namespace roomwise::guide {

struct RouteOptions {
  double person_radius_m = 0.3;   // nothing stands nearer to the route
  double comfort_m = 0.6;         // a little longer way is taken to keep so far from what stands
  double farthest_start_m = 0.6;  // from where somebody seems to stand to free floor
  double farthest_goal_m = 1.0;   // from a thing to the floor before it

  [[nodiscard]] Expected<void> validate() const;
};

// Corners of a way along free floor, m on the plan, the first where it begins.
using Route = std::vector<Eigen::Vector2d>;
[[nodiscard]] double length_m(const Route& route);
// Over stairs, where the plan has a gap, along them.
[[nodiscard]] double length_m(const Route& route, std::span<const fusion::Staircase> stairs);
// Stairs that the way takes from one corner to the next; which way round.
struct StairsOnWay {
  fusion::Staircase stairs;
  bool is_up = true;

  // Of who begins to walk over them, and of who has: others where the flight is not straight.
  [[nodiscard]] double heading_rad() const;
  [[nodiscard]] double end_heading_rad() const;
};
[[nodiscard]] std::optional<StairsOnWay> stairs_between(const Eigen::Vector2d& from,
                                                        const Eigen::Vector2d& to,
                                                        std::span<const fusion::Staircase> stairs);

// The shortest way for a person along floor that was seen free (places near obstacles count as
// longer; FloorSearch), straightened where nothing is in the way. It ends on the free place
// nearest to the goal, in `goal_room` where that and the layout are given, so that it does not end
// on the other side of a wall. Fails where somebody stands off the free floor, no free floor is
// near the goal, or no way leads there.
[[nodiscard]] Expected<Route> find_route(const fusion::FloorGrid& grid, const Eigen::Vector2d& from,
                                         const Eigen::Vector2d& to,
                                         const RouteOptions& options = {},
                                         const rooms::RoomLayout* layout = nullptr,
                                         const std::optional<std::string>& goal_room = {},
                                         std::span<const fusion::Staircase> stairs = {});

}  // namespace roomwise::guide
