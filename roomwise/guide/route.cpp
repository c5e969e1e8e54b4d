#include "roomwise/guide/route.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <queue>

namespace roomwise::guide {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;
using fusion::FloorGrid;

constexpr double kUnreached = std::numeric_limits<double>::infinity();

class RouteSearch {
 public:
  RouteSearch(const FloorGrid& grid, const RouteOptions& options)
      : grid_(grid), options_(options) {}

  // The cell where a person fits that is nearest to a point, of those that `is_wanted`.
  [[nodiscard]] std::optional<Vector2i> nearest_free(
      const Vector2d& point, double farthest_m,
      const std::function<bool(const Vector2d&)>& is_wanted) const {
    std::optional<Vector2i> nearest;
    double nearest_m = farthest_m;
    for (int row = 0; row < grid_.rows(); ++row) {
      for (int column = 0; column < grid_.columns(); ++column) {
        const Vector2d middle = grid_.cell_middle_m(column, row);
        const double distance_m = (middle - point).norm();
        if (distance_m > nearest_m || (nearest && distance_m == nearest_m)) continue;
        if (!fits({column, row}) || !is_wanted(middle)) continue;
        nearest = Vector2i(column, row);
        nearest_m = distance_m;
      }
    }
    return nearest;
  }

  // The cells from one to the other, both included; empty where there is no way.
  [[nodiscard]] std::vector<Vector2i> find(const Vector2i& from, const Vector2i& to) {
    const auto cells = static_cast<std::size_t>(grid_.columns() * grid_.rows());
    std::vector<double> cost_m(cells, kUnreached);
    std::vector<int> before(cells, -1);
    using Entry = std::pair<double, int>;  // of equal ones the cell of the lowest index first
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    cost_m[at(index_of(from))] = 0;
    open.emplace(left_m(from, to), index_of(from));
    std::vector<bool> is_done(cells);
    while (!open.empty() && open.top().second != index_of(to)) {
      const int index = open.top().second;
      open.pop();
      if (is_done[at(index)]) continue;
      is_done[at(index)] = true;
      for_each_step(cell_of(index), [&](const Vector2i& next, double step_m) {
        const double cost = cost_m[at(index)] + step_m;
        if (cost >= cost_m[at(index_of(next))]) return;
        cost_m[at(index_of(next))] = cost;
        before[at(index_of(next))] = index;
        open.emplace(cost + left_m(next, to), index_of(next));
      });
    }
    if (cost_m[at(index_of(to))] == kUnreached) return {};
    std::vector<Vector2i> way;
    for (int index = index_of(to); index >= 0; index = before[at(index)]) {
      way.push_back(cell_of(index));
    }
    std::ranges::reverse(way);
    return way;
  }

  // Leaves out corners where the straight line is as far from everything as the way was, or
  // comfortably far.
  [[nodiscard]] Route straightened(const std::vector<Vector2i>& way) const {
    Route route{middle(way.front())};
    for (std::size_t here = 0; here + 1 < way.size();) {
      std::size_t farthest = here + 1;
      double min_m = std::min(options_.comfort_m, clearance_m(way[here]));
      for (std::size_t next = here + 1; next < way.size(); ++next) {
        min_m = std::min(min_m, clearance_m(way[next]));
        if (is_clear(middle(way[here]), middle(way[next]), min_m)) farthest = next;
      }
      route.push_back(middle(way[farthest]));
      here = farthest;
    }
    return route;
  }

 private:
  [[nodiscard]] int index_of(const Vector2i& cell) const {
    return cell.y() * grid_.columns() + cell.x();
  }
  [[nodiscard]] Vector2i cell_of(int index) const {
    return {index % grid_.columns(), index / grid_.columns()};
  }
  [[nodiscard]] static std::size_t at(int index) { return static_cast<std::size_t>(index); }
  [[nodiscard]] Vector2d middle(const Vector2i& cell) const {
    return grid_.cell_middle_m(cell.x(), cell.y());
  }
  [[nodiscard]] double clearance_m(const Vector2i& cell) const {
    return grid_.clearance_m(cell.x(), cell.y());
  }
  [[nodiscard]] bool fits(const Vector2i& cell) const {
    return grid_.fits(cell.x(), cell.y(), options_.person_radius_m);
  }
  // What is left at least: in a straight line, in eight directions.
  [[nodiscard]] double left_m(const Vector2i& cell, const Vector2i& to) const {
    const Vector2i apart = (to - cell).cwiseAbs();
    return grid_.cell_m() * (apart.maxCoeff() + (std::numbers::sqrt2 - 1) * apart.minCoeff());
  }
  // The free neighbours of a cell, and what a step there counts.
  template <typename Take>
  void for_each_step(const Vector2i& cell, Take&& take) const {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const Vector2i next = cell + Vector2i(dx, dy);
        const bool is_inside =
            next.x() >= 0 && next.y() >= 0 && next.x() < grid_.columns() && next.y() < grid_.rows();
        if ((dx == 0 && dy == 0) || !is_inside || !fits(next)) continue;
        const double lacking_m = std::max(0.0, options_.comfort_m - clearance_m(next));
        const double length_m = grid_.cell_m() * (dx != 0 && dy != 0 ? std::numbers::sqrt2 : 1);
        take(next, length_m * (1 + lacking_m / options_.comfort_m));
      }
    }
  }
  [[nodiscard]] bool is_clear(const Vector2d& from, const Vector2d& to, double min_m) const {
    const auto steps = static_cast<int>(std::ceil((to - from).norm() / (grid_.cell_m() / 2)));
    for (int i = 0; i <= steps; ++i) {
      if (!grid_.fits(from + (to - from) * i / std::max(1, steps), min_m)) return false;
    }
    return true;
  }

  const FloorGrid& grid_;
  const RouteOptions& options_;
};

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
  RouteSearch search(grid, options);
  const auto start =
      search.nearest_free(from, options.farthest_start_m, [](const Vector2d&) { return true; });
  if (!start) return fail("no free floor is known where the way begins");
  const auto goal = search.nearest_free(to, options.farthest_goal_m, [&](const Vector2d& place) {
    return layout == nullptr || !goal_room || layout->room_at(place) == goal_room;
  });
  if (!goal) return fail("no free floor is known near the goal");
  const std::vector<Vector2i> way = search.find(*start, *goal);
  if (way.empty()) return fail("no free floor that is wide enough leads to the goal");
  return search.straightened(way);
}

}  // namespace roomwise::guide
