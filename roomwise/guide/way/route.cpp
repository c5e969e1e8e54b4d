#include "roomwise/guide/way/route.h"

#include <numbers>

#include "roomwise/guide/way/floor_search.h"

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

double length_m(const Route& route, std::span<const fusion::Staircase> stairs) {
  double whole_m = 0;
  for (std::size_t i = 1; i < route.size(); ++i) {
    const auto over = stairs_between(route[i - 1], route[i], stairs);
    whole_m += over ? over->stairs.run_m : (route[i] - route[i - 1]).norm();
  }
  return whole_m;
}

double StairsOnWay::heading_rad() const {
  return is_up ? stairs.up_rad : stairs.end_rad + std::numbers::pi;
}

double StairsOnWay::end_heading_rad() const {
  return is_up ? stairs.end_rad : stairs.up_rad + std::numbers::pi;
}

std::optional<StairsOnWay> stairs_between(const Vector2d& from, const Vector2d& to,
                                          std::span<const fusion::Staircase> stairs) {
  constexpr double kNear_m = 0.7;  // a little more than FloorSearch::lead_over() takes
  const auto is_near = [&](const Vector2d& a, const Vector2d& b) {
    return (a - b).norm() <= kNear_m;
  };
  for (const fusion::Staircase& one : stairs) {
    if (is_near(from, one.below_plan) && is_near(to, one.above_plan)) return StairsOnWay{one, true};
    if (is_near(from, one.above_plan) && is_near(to, one.below_plan))
      return StairsOnWay{one, false};
  }
  return std::nullopt;
}

Expected<Route> find_route(const FloorGrid& grid, const Vector2d& from, const Vector2d& to,
                           const RouteOptions& options, const rooms::RoomLayout* layout,
                           const std::optional<std::string>& goal_room,
                           std::span<const fusion::Staircase> stairs) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  FloorSearch search(grid, options.person_radius_m, options.comfort_m);
  search.lead_over(stairs);
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
