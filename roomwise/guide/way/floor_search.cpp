#include "roomwise/guide/way/floor_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <queue>

#include "roomwise/guide/places/clearance.h"

namespace roomwise::guide {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;

constexpr double kUnreached = std::numeric_limits<double>::infinity();

std::size_t at(int index) {
  return static_cast<std::size_t>(index);
}

}  // namespace

void FloorSearch::lead_over(std::span<const fusion::Staircase> stairs) {
  constexpr double kNear_m = 0.6;  // a stride from where the map says that one stands
  for (const fusion::Staircase& one : stairs) {
    const auto anywhere = [](const Vector2d&) { return true; };
    const auto below = nearest_free(one.below_plan, kNear_m, anywhere);
    const auto above = nearest_free(one.above_plan, kNear_m, anywhere);
    if (!below || !above) continue;
    const double length_m = one.run_m + one.height_m;
    links_.push_back({*below, *above, length_m});
    links_.push_back({*above, *below, length_m});
  }
}

std::optional<Vector2i> FloorSearch::nearest_free(
    const Vector2d& point, double farthest_m,
    const std::function<bool(const Vector2d&)>& is_wanted) const {
  std::optional<Vector2i> nearest;
  double nearest_m = farthest_m;
  for (int row = 0; row < grid_.rows(); ++row) {
    for (int column = 0; column < grid_.columns(); ++column) {
      const Vector2d place = grid_.cell_middle_m(column, row);
      const double distance_m = (place - point).norm();
      if (distance_m > nearest_m || (nearest && distance_m == nearest_m)) continue;
      if (!fits({column, row}) || !is_wanted(place)) continue;
      nearest = Vector2i(column, row);
      nearest_m = distance_m;
    }
  }
  return nearest;
}

// The free neighbours of a cell, and what a step there counts.
template <typename Take>
void FloorSearch::for_each_step(const Vector2i& cell, Take&& take) const {
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const Vector2i next = cell + Vector2i(dx, dy);
      const bool is_inside =
          next.x() >= 0 && next.y() >= 0 && next.x() < grid_.columns() && next.y() < grid_.rows();
      if ((dx == 0 && dy == 0) || !is_inside || !fits(next)) continue;
      const double lacking_m = std::max(0.0, comfort_m_ - clearance_m(next));
      const double length_m = grid_.cell_m() * (dx != 0 && dy != 0 ? std::numbers::sqrt2 : 1);
      take(next, length_m * (1 + lacking_m / comfort_m_));
    }
  }
  for (const Link& link : links_) {
    if (link.from == cell) take(link.to, link.length_m);
  }
}

std::vector<Vector2i> FloorSearch::find(const Vector2i& from, const EndCost& end_cost) const {
  const auto cells = at(grid_.columns() * grid_.rows());
  std::vector<double> cost_m(cells, kUnreached);
  std::vector<int> before(cells, -1);
  std::vector<bool> is_done(cells);
  using Entry = std::pair<double, int>;  // of equal ones the cell of the lowest index first
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  cost_m[at(index_of(from))] = 0;
  open.emplace(0.0, index_of(from));
  int end = -1;
  double cheapest_m = kUnreached;
  while (!open.empty() && open.top().first < cheapest_m) {
    const int index = open.top().second;
    open.pop();
    if (is_done[at(index)]) continue;
    is_done[at(index)] = true;
    const auto ending_m = end_cost(middle(cell_of(index)));
    if (ending_m && cost_m[at(index)] + *ending_m < cheapest_m) {
      cheapest_m = cost_m[at(index)] + *ending_m;
      end = index;
    }
    for_each_step(cell_of(index), [&](const Vector2i& next, double step_m) {
      const double cost = cost_m[at(index)] + step_m;
      if (cost >= cost_m[at(index_of(next))]) return;
      cost_m[at(index_of(next))] = cost;
      before[at(index_of(next))] = index;
      open.emplace(cost, index_of(next));
    });
  }
  std::vector<Vector2i> way;
  for (int index = end; index >= 0; index = before[at(index)]) way.push_back(cell_of(index));
  std::ranges::reverse(way);
  return way;
}

Route FloorSearch::straightened(const std::vector<Vector2i>& way, double enough_m) const {
  Route route{middle(way.front())};
  for (std::size_t here = 0; here + 1 < way.size();) {
    std::size_t farthest = here + 1;
    double min_m = std::min(enough_m, clearance_m(way[here]));
    for (std::size_t next = here + 1; next < way.size(); ++next) {
      min_m = std::min(min_m, clearance_m(way[next]));
      if (is_clear(grid_, middle(way[here]), middle(way[next]), min_m)) farthest = next;
    }
    route.push_back(middle(way[farthest]));
    here = farthest;
  }
  return route;
}

}  // namespace roomwise::guide
