#include "roomwise/guide/way/legs.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace roomwise::guide {
namespace {

using Eigen::Vector2d;

constexpr double kShortLeg_m = 0.4;  // a corner that is cut, not a leg
constexpr double kPoint_m = 0.01;    // less than a cell: no way at all

// How much of a leg is walked when it comes from one side of a doorway to the other; nothing where
// it does not: who walks past one stays in the room.
std::optional<double> share_at(const Vector2d& from, const Vector2d& to,
                               const rooms::Doorway& doorway) {
  const Vector2d& middle = doorway.middle_plan;
  const bool knows_sides = doorway.width_m > 0;
  if (!knows_sides) {
    const double share = (middle - from).dot(to - from) / (to - from).squaredNorm();
    return share > 0 && share < 1 ? std::optional(share) : std::nullopt;
  }
  const Vector2d across(-std::sin(doorway.direction_rad), std::cos(doorway.direction_rad));
  const double from_m = (from - middle).dot(across), to_m = (to - middle).dot(across);
  if ((from_m > 0) == (to_m > 0)) return std::nullopt;
  return from_m / (from_m - to_m);
}

// The place on a leg where it leads through a doorway; nothing where it does not.
std::optional<Vector2d> door_on(const Vector2d& from, const Vector2d& to,
                                const rooms::Doorway& doorway) {
  const auto share = share_at(from, to, doorway);
  if (!share) return std::nullopt;
  const Vector2d place = from + *share * (to - from);
  const double reach_m = std::max(0.4, doorway.width_m / 2);
  const bool is_through = (place - doorway.middle_plan).norm() <= reach_m;
  return is_through ? std::optional(place) : std::nullopt;
}

// A leg from each corner to the next, in parts where it leads through doors.
std::vector<Leg> parts_of(const Route& route, std::span<const rooms::Doorway> doors,
                          std::span<const fusion::Staircase> stairs) {
  using Passed = std::pair<Vector2d, const rooms::Doorway*>;
  std::vector<Leg> legs;
  for (std::size_t i = 1; i < route.size(); ++i) {
    Vector2d from = route[i - 1];
    if (const auto over = stairs_between(from, route[i], stairs)) {
      legs.push_back({from, route[i], over->stairs.run_m, over});
      continue;
    }
    std::vector<Passed> passed;
    for (const rooms::Doorway& door : doors) {
      if (!door.is_door() && !door.is_opening()) continue;
      if (const auto place = door_on(from, route[i], door)) passed.emplace_back(*place, &door);
    }
    std::ranges::sort(passed, {},
                      [&](const Passed& one) { return (one.first - route[i - 1]).norm(); });
    for (const auto& [place, door] : passed) {
      if ((place - from).norm() > kPoint_m) {
        legs.push_back({from, place, (place - from).norm(), {}, door});
      } else if (!legs.empty() && !legs.back().stairs) {
        legs.back().doorway = door;  // at a corner
      }
      from = place;
    }
    if ((route[i] - from).norm() > kPoint_m) {
      legs.push_back({from, route[i], (route[i] - from).norm()});
    }
  }
  return legs;
}

}  // namespace

double Leg::heading_rad() const {
  return stairs ? stairs->heading_rad() : heading_to(from, to);
}

Vector2d Leg::along() const {
  return {std::cos(heading_rad()), std::sin(heading_rad())};
}

std::vector<Leg> legs_of(const Route& route, std::span<const rooms::Doorway> doors,
                         std::span<const fusion::Staircase> stairs) {
  std::vector<Leg> result;
  for (const Leg& leg : parts_of(route, doors, stairs)) {
    const bool is_apart = leg.stairs || (!result.empty() && result.back().stairs);
    if (!result.empty() && result.back().doorway == nullptr && !is_apart) {
      Leg& last = result.back();
      const double turn = turn_rad(last.heading_rad(), leg.heading_rad());
      if (std::abs(turn) < kNoTurn_rad || std::min(last.length_m, leg.length_m) < kShortLeg_m) {
        last = {last.from, leg.to, last.length_m + leg.length_m, {}, leg.doorway};
        continue;
      }
    }
    result.push_back(leg);
  }
  return result;
}

std::vector<rooms::Doorway> doors_of(std::span<const rooms::Doorway> doorways) {
  std::vector<rooms::Doorway> doors;
  std::ranges::copy_if(doorways, std::back_inserter(doors), &rooms::Doorway::is_door);
  return doors;
}

// At its end it would be missed by a step's half; but not finer than people turn.
double straight_enough_rad(double length_m) {
  return std::clamp(std::atan2(0.4, length_m), 15 * kDegree_rad, 25 * kDegree_rad);
}

double heading_to(const Vector2d& from, const Vector2d& to) {
  return std::atan2(to.y() - from.y(), to.x() - from.x());
}

double turn_rad(double from_rad, double to_rad) {
  return std::remainder(to_rad - from_rad, 2 * std::numbers::pi);
}

}  // namespace roomwise::guide
