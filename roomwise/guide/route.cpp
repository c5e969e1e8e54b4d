#include "roomwise/guide/route.h"

#include "roomwise/guide/floor_search.h"

namespace roomwise::guide {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;
using fusion::FloorGrid;

}  // namespace

Expected<void> RouteOptions::validate() const {
  if (!(person_radius_m > 0)) {
    return fail("person_radius_m is {}; expected more than 0", person_radius_m);
  }
  if (!(comfort_m >= person_radius_m)) {
    return fail("comfort_m is {}; expected person_radius_m, {}, or more", comfort_m,
                person_radius_m);
  }
  if (!(farthest_start_m > 0 && farthest_goal_m > 0)) {
    return fail("farthest_start_m is {} and farthest_goal_m {}; expected more than 0",
                farthest_start_m, farthest_goal_m);
  }
  return {};
}

double length_m(const Route& route) {
  double length_m = 0;
  for (std::size_t i = 1; i < route.size(); ++i) length_m += (route[i] - route[i - 1]).norm();
  return length_m;
}

Expected<Route> find_route(const FloorGrid& grid, const Vector2d& from, const Vector2d& to,
                           const RouteOptions& options, const rooms::RoomLayout* layout,
                           const std::optional<std::string>& goal_room) {
  ROOMWISE_CHECK_OK(options.validate());
  const FloorSearch search(grid, options.person_radius_m, options.comfort_m);
  const auto start =
      search.nearest_free(from, options.farthest_start_m, [](const Vector2d&) { return true; });
  if (!start) return fail("no free floor is known where the way begins");
  const auto goal = search.nearest_free(to, options.farthest_goal_m, [&](const Vector2d& place) {
    return layout == nullptr || !goal_room || layout->room_at(place) == goal_room;
  });
  if (!goal) return fail("no free floor is known near the goal");
  const Vector2d end = grid.cell_middle_m(goal->x(), goal->y());
  const std::vector<Vector2i> way = search.find(*start, [&](const Vector2d& place) {
    return place == end ? std::optional(0.0) : std::nullopt;
  });
  if (way.empty()) return fail("no free floor that is wide enough leads to the goal");
  return search.straightened(way, options.comfort_m);
}

}  // namespace roomwise::guide
