#include "roomwise/guide/route_prompts.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace roomwise::guide {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kMaxLegs = 4;
constexpr double kThere_m = 0.5;     // less than a step: nobody needs to be told
constexpr double kShortLeg_m = 0.4;  // a corner that is cut, not a leg
constexpr double kDegree = std::numbers::pi / 180;

struct Leg {
  Vector2d from = Vector2d::Zero();
  Vector2d to = Vector2d::Zero();
  double length_m = 0;  // along corners that are not spoken of
  bool ends_at_door = false;

  [[nodiscard]] double heading_rad() const {
    return std::atan2(to.y() - from.y(), to.x() - from.x());
  }
};

// The place on a leg where it passes a doorway; nothing where it does not.
std::optional<Vector2d> door_on(const Vector2d& from, const Vector2d& to,
                                const rooms::Doorway& doorway) {
  const Vector2d along = to - from;
  const double share = (doorway.middle_gravity - from).dot(along) / along.squaredNorm();
  const Vector2d place = from + share * along;
  const double reach_m = std::max(0.4, doorway.width_m / 2);
  const bool is_passed =
      share > 0 && share < 1 && (place - doorway.middle_gravity).norm() <= reach_m;
  return is_passed ? std::optional(place) : std::nullopt;
}

// A leg from each corner to the next, in parts where it leads through doors.
std::vector<Leg> legs_of(const Route& route, std::span<const rooms::Doorway> doorways) {
  std::vector<Leg> legs;
  for (std::size_t i = 1; i < route.size(); ++i) {
    Vector2d from = route[i - 1];
    std::vector<Vector2d> doors;
    for (const rooms::Doorway& doorway : doorways) {
      if (const auto door = door_on(from, route[i], doorway)) doors.push_back(*door);
    }
    std::ranges::sort(doors, {},
                      [&](const Vector2d& door) { return (door - route[i - 1]).norm(); });
    for (const Vector2d& door : doors) {
      legs.push_back({from, door, (door - from).norm(), true});
      from = door;
    }
    legs.push_back({from, route[i], (route[i] - from).norm(), false});
  }
  return legs;
}

// From -pi to pi, positive to the left.
double turn_rad(double from_rad, double to_rad) {
  return std::remainder(to_rad - from_rad, 2 * std::numbers::pi);
}

const char* turn_message(double turn_rad) {
  const double degrees = turn_rad / kDegree;
  if (std::abs(degrees) < 20) return "route.straight";
  if (std::abs(degrees) > 135) return "route.around";
  if (std::abs(degrees) < 60) return degrees > 0 ? "route.slight_left" : "route.slight_right";
  return degrees > 0 ? "route.left" : "route.right";
}

// Joins legs that go on nearly straight, and short ones with what comes after them, unless there is
// a door between.
std::vector<Leg> joined(std::vector<Leg> legs) {
  std::vector<Leg> result;
  for (const Leg& leg : legs) {
    if (!result.empty() && !result.back().ends_at_door) {
      Leg& last = result.back();
      const double turn = turn_rad(last.heading_rad(), leg.heading_rad());
      if (std::abs(turn) < 20 * kDegree || std::min(last.length_m, leg.length_m) < kShortLeg_m) {
        last = {last.from, leg.to, last.length_m + leg.length_m, leg.ends_at_door};
        continue;
      }
    }
    result.push_back(leg);
  }
  return result;
}

}  // namespace

std::vector<Prompt> route_prompts(const Route& route, const Pose& pose, const Noun& goal,
                                  std::span<const rooms::Doorway> doorways, const Wording& wording,
                                  TimestampNs now_ns) {
  const double whole_m = length_m(route);
  const auto made = [&](std::size_t part, const std::string& message, const Values& values) {
    return make_part(wording, "route", part, message, values, Confidence::kSure, now_ns,
                     kDirectionValid_s, fmt::format("a way of {:.1f} m along free floor", whole_m));
  };
  if (whole_m < kThere_m) return {made(0, "route.arrived", {{"goal", Nouns{goal}}})};
  const std::vector<Leg> legs = joined(legs_of(route, doorways));
  std::vector<Prompt> prompts;
  double heading_rad = pose.heading_rad;
  for (std::size_t i = 0; i < std::min(legs.size(), kMaxLegs); ++i) {
    const Leg& leg = legs[i];
    const std::string turn =
        wording.phrases().text(turn_message(turn_rad(heading_rad, leg.heading_rad())));
    heading_rad = leg.heading_rad();
    const bool is_last = i + 1 == legs.size();
    prompts.push_back(made(
        i,
        is_last            ? "route.step_goal"
        : leg.ends_at_door ? "route.step_door"
                           : "route.step",
        {{"turn", turn}, {"distance", wording.distance(leg.length_m)}, {"goal", Nouns{goal}}}));
  }
  return prompts;
}

Prompt no_route_prompt(bool has_pose, std::string because, const Wording& wording,
                       TimestampNs now_ns) {
  return make_prompt(wording, "route", has_pose ? "route.none" : "route.no_place", {},
                     Confidence::kUnsure, after(now_ns, kRoomValid_s), std::move(because));
}

}  // namespace roomwise::guide
