#include "laboratory/simulation/scene/stair_fittings.h"

#include <cmath>

namespace roomwise::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kRail_m = 0.9;       // over the edges of the steps
constexpr double kHandrail_m = 0.06;  // thick
constexpr double kBaluster_m = 0.035;
constexpr double kBalusterEvery_m = 0.14;

Vector3f in_space(const Vector2d& place, double height_m) {
  return {static_cast<float>(place.x()), static_cast<float>(place.y()),
          static_cast<float>(height_m)};
}

// A rail from one place to another, at these heights of what it stands on.
void add_rail(Fittings& fittings, const Vector2d& from, double from_m, const Vector2d& to,
              double to_m, std::uint32_t wood, std::uint32_t metal) {
  const Vector2d along = (to - from).normalized();
  const Vector2d aside(-along.y(), along.x());
  const double length_m = (to - from).norm();
  fittings.add_box(in_space(from - kHandrail_m / 2 * aside, from_m + kRail_m - kHandrail_m),
                   in_space(to, to_m) - in_space(from, from_m), in_space(kHandrail_m * aside, 0),
                   in_space(Vector2d::Zero(), kHandrail_m), wood);
  const int balusters = static_cast<int>(length_m / kBalusterEvery_m);
  for (int i = 0; i <= balusters; ++i) {
    const double share = balusters == 0 ? 0.0 : static_cast<double>(i) / balusters;
    const Vector2d place = from + share * (to - from) - kBaluster_m / 2 * (along + aside);
    fittings.add_box(in_space(place, from_m + share * (to_m - from_m) - 0.1),
                     in_space(kBaluster_m * along, 0), in_space(kBaluster_m * aside, 0),
                     in_space(Vector2d::Zero(), kRail_m), metal);
  }
}

}  // namespace

void add_stair_rails(Fittings& fittings, const HomeModel& home) {
  if (home.stairs.empty()) return;
  const std::uint32_t wood =
      fittings.add_look(Appearance::plain(Vector3f(0.23F, 0.12F, 0.06F), 0.04F, 50));
  const std::uint32_t metal =
      fittings.add_look(Appearance::plain(Vector3f(0.62F, 0.61F, 0.58F), 0.03F, 40));
  for (const Staircase& stairs : home.stairs) {
    const Vector2d right(stairs.up.y(), -stairs.up.x());
    const double floor_m = home.rooms[stairs.lower_room].floor_m;
    const double inset_m = stairs.width_m / 2 - kHandrail_m;
    const Vector2d top = stairs.foot + stairs.run_m() * stairs.up;
    for (const double side : {-1.0, 1.0}) {
      if (side < 0 ? !stairs.has_left_rail : !stairs.has_right_rail) continue;
      const Vector2d beside = side * inset_m * right;
      add_rail(fittings, stairs.foot + beside, floor_m + stairs.rise_m, top + beside,
               floor_m + stairs.height_m(), wood, metal);
      // Along the edge of the floor above, from the flight to the wall.
      const Rectangle& open = *home.rooms[stairs.upper_room].open_floor;
      const Vector2d edge = top + side * stairs.width_m / 2 * right + 0.04 * stairs.up;
      const Vector2d wall = edge.cwiseMax(open.min).cwiseMin(open.max);
      Vector2d far = wall;
      const int across = std::abs(right.x()) > 0.5 ? 0 : 1;
      far[across] = side * right[across] > 0 ? open.max[across] : open.min[across];
      far[1 - across] = edge[1 - across];
      add_rail(fittings, edge, floor_m + stairs.height_m(), far, floor_m + stairs.height_m(), wood,
               metal);
    }
  }
}

std::vector<StairFace> stair_faces(const HomeModel& home) {
  std::vector<StairFace> faces;
  const auto f = [](double value) { return static_cast<float>(value); };
  const Vector3f z = Vector3f::UnitZ();
  for (const Staircase& stairs : home.stairs) {
    const Room& lower = home.rooms[stairs.lower_room];
    const Vector2d right(stairs.up.y(), -stairs.up.x());
    const Vector3f up = in_space(stairs.up, 0), aside = in_space(right, 0);
    const Vector2d left_foot = stairs.foot - stairs.width_m / 2 * right;
    for (int step = 0; step < stairs.steps; ++step) {
      const double under_m = lower.floor_m + step * stairs.rise_m;
      const Vector2d edge = left_foot + step * stairs.going_m * stairs.up;
      faces.push_back({in_space(edge, under_m), aside, z, -up, f(stairs.width_m), f(stairs.rise_m),
                       &lower.ceiling});
      if (step + 1 == stairs.steps) continue;  // the last riser ends on the floor above
      const double over_m = under_m + stairs.rise_m;
      faces.push_back({in_space(edge, over_m), aside, up, z, f(stairs.width_m), f(stairs.going_m),
                       &stairs.finish});
      const double height_m = over_m - lower.floor_m;
      faces.push_back({in_space(edge, lower.floor_m), up, z, -aside, f(stairs.going_m), f(height_m),
                       &lower.walls});
      faces.push_back({in_space(edge + stairs.width_m * right, lower.floor_m), up, z, aside,
                       f(stairs.going_m), f(height_m), &lower.walls});
    }
    // Under the landing the flight's back, and the edges of the slab around the opening.
    const Vector2d top = left_foot + stairs.run_m() * stairs.up;
    faces.push_back({in_space(top, lower.floor_m), aside, z, up, f(stairs.width_m),
                     f(home.ceiling_height_m), &lower.walls});
    const double slab_m = stairs.height_m() - home.ceiling_height_m;
    const Rectangle& open = *lower.open_ceiling;
    const double ceiling_m = lower.floor_m + home.ceiling_height_m;
    const Vector2d size = open.max - open.min;
    const Vector3f x = Vector3f::UnitX(), y = Vector3f::UnitY();
    const Vector2d corner_x(open.max.x(), open.min.y()), corner_y(open.min.x(), open.max.y());
    faces.push_back({in_space(open.min, ceiling_m), x, z, y, f(size.x()), f(slab_m), &lower.walls});
    faces.push_back(
        {in_space(corner_y, ceiling_m), x, z, -y, f(size.x()), f(slab_m), &lower.walls});
    faces.push_back({in_space(open.min, ceiling_m), y, z, x, f(size.y()), f(slab_m), &lower.walls});
    faces.push_back(
        {in_space(corner_x, ceiling_m), y, z, -x, f(size.y()), f(slab_m), &lower.walls});
  }
  return faces;
}

}  // namespace roomwise::simulation
