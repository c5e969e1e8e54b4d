#include "roomwise/guide/places/places.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <numbers>
#include <set>

#include "roomwise/objects/kinds/kinds.h"

namespace roomwise::guide {
namespace {

// An hour reaches 15 degrees to each side.
constexpr double kHalfHour_rad = std::numbers::pi / 12;
// In reach of a hand that is stretched out: nobody needs steps to get there.
constexpr double kClose_m = 0.8;
// One in five such things is not there, or is called otherwise.
constexpr double kThingSureFrom = 0.8;

}  // namespace

Eigen::Vector2d Pose::place_of(const Eigen::Vector2d& ahead_left_m) const {
  return position_plan + Eigen::Rotation2Dd(heading_rad) * ahead_left_m;
}

Eigen::Vector2d Pose::ahead_left_of(const Eigen::Vector2d& place_plan) const {
  return Eigen::Rotation2Dd(-heading_rad) * (place_plan - position_plan);
}

const Pose* UserLocation::sure_pose() const {
  return pose && pose->sigma_m <= kMaxSigma_m ? &*pose : nullptr;
}

double KnownThing::probability_at(const std::optional<CalendarTime>& today) const {
  constexpr double kHoursPerDay = 24;
  if (added_by_edit != 0 || !seen || !today) return probability;  // a helper's word stands
  const int hours = seen->hours_until(*today);
  if (hours <= 0) return probability;  // or a clock is wrong
  return probability * objects::probability_still_there(name, hours / kHoursPerDay);
}

bool KnownThing::is_sure(const std::optional<CalendarTime>& today) const {
  return probability_at(today) >= kThingSureFrom;
}

bool Bearing::is_close() const {
  return distance_m < kClose_m;
}

Bearing bearing_of(const Eigen::Vector2d& point_plan, const Pose& pose, double radius_m) {
  const Eigen::Vector2d towards = point_plan - pose.position_plan;
  const double distance_m = towards.norm();
  const double clockwise_rad = pose.heading_rad - std::atan2(towards.y(), towards.x());
  const auto hour = static_cast<int>(std::lround(clockwise_rad / (2 * kHalfHour_rad))) % 12;
  Bearing bearing;
  bearing.hour = hour <= 0 ? hour + 12 : hour;
  bearing.distance_m = std::max(0.0, distance_m - radius_m);
  bearing.is_sure = pose.sigma_m <= distance_m * std::tan(kHalfHour_rad);
  return bearing;
}

std::optional<Bearing> bearing_of(const KnownThing& thing, const Pose& pose) {
  if (!thing.position_plan) return std::nullopt;
  return bearing_of(thing.position_plan->head<2>(), pose, thing.size_m().head<2>().minCoeff() / 2);
}

std::vector<std::string> way_between_rooms(const std::string& from, const std::string& to,
                                           std::span<const rooms::Doorway> doorways) {
  std::map<std::string, std::set<std::string>> neighbors;
  for (const rooms::Doorway& doorway : doorways) {
    neighbors[doorway.rooms[0]].insert(doorway.rooms[1]);
    neighbors[doorway.rooms[1]].insert(doorway.rooms[0]);
  }
  // From the goal, so that each room knows the next one on the way there.
  std::map<std::string, std::string> next{{to, to}};
  for (std::deque<std::string> frontier{to}; !frontier.empty(); frontier.pop_front()) {
    const std::string here = frontier.front();
    for (const std::string& neighbor : neighbors[here]) {
      if (next.emplace(neighbor, here).second) frontier.push_back(neighbor);
    }
  }
  if (!next.contains(from)) return {};
  std::vector<std::string> way{from};
  while (way.back() != to) way.push_back(next.at(way.back()));
  return way;
}

}  // namespace roomwise::guide
