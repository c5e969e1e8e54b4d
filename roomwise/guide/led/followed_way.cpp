#include "roomwise/guide/led/followed_way.h"

#include <algorithm>
#include <cmath>

#include "roomwise/guide/places/clearance.h"
#include "roomwise/guide/places/home_map.h"
#include "roomwise/guide/places/surfaces.h"
#include "roomwise/guide/way/way_phrases.h"

namespace roomwise::guide {
namespace {

using Eigen::Vector2d;

constexpr double kBeyondDoor_m = 0.45;  // both feet are, and not in its frame

}  // namespace

void FollowedWay::plan_from(const UserLocation& from, const BarredFloor& floor) {
  HomeMap map = map_;
  map.floor = floor.grid();
  plan_ = plan_way(map, from, goal_, options_.plan);
  legs_ = legs_of(plan_.route, map_.doorways, home_stairs());
  if (leads_to_goal()) reach_out();
  leg_ = 0;
  // What is left of a leg that ends here is done.
  while (!is_last_leg() && !leg().stairs &&
         (left_on_leg_m(*from.pose) < kLegEnd_m || may_skip_leg(*from.pose, floor))) {
    ++leg_;
  }
  step_clear(*from.pose, floor);
}

// Up to a thing one walks until a hand or a cane is at it: the last leg goes on to where the body
// would touch it; to a door's frame, until one stands in it.
void FollowedWay::reach_out() {
  if (goal_.kind == Goal::Kind::kRoom) return;
  const double body_m = goal_.kind == Goal::Kind::kDoor ? 0 : options_.body_radius_m;
  const Vector2d from = has_legs() ? legs_.back().to : plan_.route.back();
  const Vector2d towards = plan_.touch_plan - from;
  double further_m = std::min(towards.norm() - body_m, kHand_m / 2);
  const auto end = [&] { return Vector2d(from + further_m * towards.normalized()); };
  // As far as the body fits; the rest is for a hand.
  const auto fits = [&] { return map_.floor->fits(end(), options_.plan.narrow_radius_m); };
  while (further_m > 0 && !fits()) further_m -= map_.floor->cell_m();
  if (further_m <= 0) return;
  if (!has_legs()) {
    if (further_m > kAtEnd_m) legs_.push_back({from, end(), further_m});
    return;
  }
  legs_.back().length_m += further_m;
  legs_.back().to = end();
}

// A leg leaves out small corners, and somebody may stand beside it, nearer to things than ways
// lead: who then went straight to its end would touch them. First a step to where the way is clear.
void FollowedWay::step_clear(const Pose& pose, const BarredFloor& floor) {
  if (!has_legs() || leg().stairs) return;
  const Vector2d& here = pose.position_plan;
  const double narrow_m = floor.narrow_m_at(here, options_.plan.narrow_radius_m);
  const auto is_clear_to = [&](const Vector2d& place) {
    return is_clear(*floor.grid(), here, place, narrow_m);
  };
  if (is_clear_to(leg().to)) return;
  std::optional<Vector2d> farthest;
  for (std::size_t i = 0; i + 1 < plan_.route.size(); ++i) {
    const Vector2d along = plan_.route[i + 1] - plan_.route[i];
    const int parts =
        std::max(1, static_cast<int>(std::ceil(along.norm() / floor.grid()->cell_m())));
    for (int part = 0; part <= parts; ++part) {
      const Vector2d place = plan_.route[i] + along * part / parts;
      if ((place - here).norm() >= kAtEnd_m && is_clear_to(place)) farthest = place;
    }
    if (plan_.route[i + 1] == leg().to) break;
  }
  if (!farthest) return;
  Leg& next = legs_[leg_];
  next.from = *farthest;
  next.length_m = (next.to - next.from).norm();
  legs_.insert(legs_.begin() + static_cast<std::ptrdiff_t>(leg_),
               Leg{here, *farthest, (*farthest - here).norm()});
}

// A leg of less than a step, which only leads to where one may go at once.
bool FollowedWay::may_skip_leg(const Pose& pose, const BarredFloor& floor) const {
  if (to_end_m(pose) > kHand_m || leg().ends_at_door()) return false;
  if (goes_over_stairs_next()) return false;  // one begins them where they begin
  return is_clear(*floor.grid(), pose.position_plan, next_leg().to, options_.plan.narrow_radius_m);
}

std::span<const fusion::Staircase> FollowedWay::home_stairs() const {
  return map_.storeys != nullptr ? std::span(map_.storeys->stairs())
                                 : std::span<const fusion::Staircase>();
}

// ---- the leg ----

bool FollowedWay::goes_straight_on() const {
  return !is_last_leg() && !goes_over_stairs_next() &&
         std::abs(turn_rad(leg().heading_rad(), next_leg().heading_rad())) < kNoTurn_rad;
}

std::optional<Noun> FollowedWay::place_at_end() const {
  if (ends_at_goal()) return goal_.noun;
  if (leg().ends_at_door()) return Noun{Noun::Kind::kThing, "door"};
  if (const auto room = room_beyond()) return Noun{Noun::Kind::kRoom, *room};
  const KnownThing* const thing = thing_at_end().first;
  return thing != nullptr ? std::optional(Noun{Noun::Kind::kThing, thing->name}) : std::nullopt;
}

std::string FollowedWay::side_at_end() const {
  const std::string side = thing_at_end().second;
  return side == "_ahead" ? "" : side;
}

std::pair<const KnownThing*, std::string> FollowedWay::thing_at_end() const {
  if (ends_at_goal() || leg().ends_at_door() || room_beyond()) return {};
  const KnownThing* const thing =
      nearest_sure_thing(leg().to, kHand_m + options_.body_radius_m, map_);
  if (thing == nullptr) return {};
  const Vector2d touch = outline_of(*thing).nearest_to(leg().to);
  std::string side = with_side("", touch, {leg().to, leg().heading_rad()});
  // Nobody walks to what they have passed by then.
  if (side == "_behind") return {};
  return {thing, std::move(side)};
}

std::optional<std::string> FollowedWay::room_beyond() const {
  if (leg().doorway == nullptr || leg().ends_at_door()) return std::nullopt;
  const Vector2d step = kBeyondDoor_m * leg().along();
  auto room = map_.room_at(leg().to + step);
  const bool is_other = room && room != map_.room_at(leg().to - step);
  return is_other && leg().doorway->joins(*room) ? room : std::nullopt;
}

Vector2d FollowedWay::next_place() const {
  return leg().stairs ? Vector2d(leg().from + leg().along()) : leg().to;
}

double FollowedWay::left_on_leg_m(const Pose& pose) const {
  return leg().stairs ? leg().length_m : (leg().to - pose.position_plan).dot(leg().along());
}

double FollowedWay::bearing_error_rad(const Pose& pose) const {
  // So near to its end, its own direction says more than that of a point underfoot.
  const bool is_near = leg().stairs || to_end_m(pose) < 2 * kLegEnd_m;
  return turn_rad(pose.heading_rad,
                  is_near ? leg().heading_rad() : heading_to(pose.position_plan, leg().to));
}

bool FollowedWay::is_off(const Pose& pose) const {
  const Vector2d along = leg().along(), aside = pose.position_plan - leg().from;
  const double beside_m = std::abs(along.x() * aside.y() - along.y() * aside.x());
  return beside_m > options_.off_way_m ||
         std::abs(bearing_error_rad(pose)) > options_.off_way_degrees * kDegree_rad;
}

bool FollowedWay::may_keep_leg(const Pose& pose, const BarredFloor& floor) const {
  if (!leads_to_goal() || !has_legs() || leg().stairs || to_end_m(pose) < kLegEnd_m) return false;
  const double narrow_m = floor.narrow_m_at(pose.position_plan, options_.plan.narrow_radius_m);
  return is_clear(*floor.grid(), pose.position_plan, leg().to, narrow_m);
}

double FollowedWay::left_m(const Pose& pose) const {
  double left_m = 0;
  for (std::size_t i = leg_; i < legs_.size(); ++i) {
    left_m += i == leg_ && !legs_[i].stairs ? to_end_m(pose) : legs_[i].length_m;
  }
  return left_m;
}

// A turn is what they were told, give or take little, and a step on free floor leads on to where
// they are seen.
std::optional<double> FollowedWay::unseen_step_m(const Pose& last, std::optional<double> obstacle_m,
                                                 const BarredFloor& floor) const {
  if (!has_legs() || floor.grid() == nullptr) return std::nullopt;
  if (leg().stairs || goes_over_stairs_next()) return std::nullopt;
  // Two steps, or what is left of the leg where that is less.
  const double step_m = std::min(to_end_m(last), kHand_m + kLegEnd_m);
  const Vector2d& here = last.position_plan;
  const Vector2d end = here + step_m * (leg().to - here).normalized();
  const auto is_near = [&](const Vector2d& place) { return (place - end).norm() < 2 * kHand_m; };
  const bool is_near_stairs = std::ranges::any_of(home_stairs(), [&](const auto& stairs) {
    return is_near(stairs.below_plan) || is_near(stairs.above_plan);
  });
  // Depth tells otherwise than the map: they do not face where they should.
  const bool is_barred =
      obstacle_m && *obstacle_m < step_m + options_.body_radius_m && !is_goal(end);
  const bool may_go =
      !is_near_stairs && !is_barred && is_clear(*floor.grid(), here, end, kPlaceError_m);
  return may_go ? std::optional(step_m) : std::nullopt;
}

// ---- the goal ----

bool FollowedWay::is_in_goal_room(const Pose& pose) const {
  return map_.layout == nullptr || !goal_.room || goal_.kind == Goal::Kind::kDoor ||
         map_.room_at(pose.position_plan) == goal_.room;
}

bool FollowedWay::has_arrived(const Pose& pose, bool is_standing) {
  if (!is_at_goal(pose)) {
    at_goal_by_.reset();
    return false;
  }
  if (!at_goal_by_) at_goal_by_ = pose.position_plan;
  return *at_goal_by_ != pose.position_plan || is_standing;
}

bool FollowedWay::is_at_goal(const Pose& pose) const {
  if (!leads_to_goal() || !is_in_goal_room(pose)) return false;
  const Vector2d& end = has_legs() ? legs_.back().to : plan_.route.back();
  const double to_end_m = (end - pose.position_plan).norm();
  // Not from where it is the next room to some.
  const bool may_be_between = map_.layout == nullptr || !goal_.room ||
                              goal_.kind == Goal::Kind::kDoor ||
                              !is_well_inside(map_, *goal_.room, end);
  if (!may_be_between && !is_well_inside(map_, *goal_.room, pose.position_plan)) return false;
  // Anywhere beyond the door is in the room, but who stands in the door is not.
  if (goal_.kind == Goal::Kind::kRoom) {
    return to_end_m < kAtEnd_m ||
           std::ranges::all_of(map_.doorways, [&](const rooms::Doorway& doorway) {
             return !doorway.joins(*goal_.room) ||
                    (doorway.place_in(*goal_.room) - pose.position_plan).norm() > kBeyondDoor_m;
           });
  }
  // What stands on something is reached from where the way ends; a spot is stood on, and so is what
  // lies so low that the floor counts as free.
  const bool is_low = map_.floor->at(goal_.outline->nearest_to(end)) == fusion::FloorCell::kFree;
  const bool is_door = goal_.kind == Goal::Kind::kDoor;
  const double body_m = is_low || is_door ? 0 : options_.body_radius_m;
  return to_end_m < kAtEnd_m || goal_.outline->distance_m(pose.position_plan) <=
                                    options_.arrived_m + body_m - kPlaceError_m;
}

bool FollowedWay::comes_to_rest(const Pose& pose) const {
  if (goal_.kind == Goal::Kind::kRoom) return true;
  const Vector2d touch = goal_.outline->nearest_to(pose.position_plan);
  return goal_.is_solid() && with_side("", touch, pose) == "_ahead";
}

bool FollowedWay::is_last_step(const Pose& pose) const {
  return goal_.is_solid() && has_legs() && is_last_leg() && leads_to_goal() &&
         std::abs(bearing_error_rad(pose)) <= straight_enough_rad(to_end_m(pose)) &&
         to_end_m(pose) < kHand_m + kLegEnd_m && comes_to_rest({leg().to, leg().heading_rad()});
}

bool FollowedWay::is_in_reach(const Pose& pose) const {
  if (!goal_.outline || goal_.kind == Goal::Kind::kRoom) return true;
  const double at_end_m = goal_.outline->distance_m(plan_.route.back());
  return goal_.outline->distance_m(pose.position_plan) <=
         std::max(options_.arrived_m + options_.body_radius_m, at_end_m);
}

bool FollowedWay::is_goal(const Vector2d& obstacle) const {
  return goal_.is_solid() && is_last_leg() && leads_to_goal() && goal_.outline &&
         goal_.outline->distance_m(obstacle) < kHand_m;
}

// One must be able to walk straight at it until one is there, or for all but half a step: the tone
// leads nobody around what stands beside the way.
std::optional<GoalBearing> FollowedWay::goal_bearing(const Pose& pose,
                                                     const BarredFloor& floor) const {
  const bool is_near_end = leads_to_goal() && has_legs() && is_last_leg() && !leg().stairs;
  if (!is_near_end || !goal_.is_solid() || !goal_.is_sure) return std::nullopt;
  const Vector2d& here = pose.position_plan;
  const Bearing bearing = bearing_of(plan_.touch_plan, pose);
  if (!bearing.is_sure || bearing.distance_m > options_.announce_to_m) return std::nullopt;
  const double end_m = (plan_.touch_plan - leg().to).norm();
  const double further_m =
      bearing.distance_m - std::max(end_m, options_.arrived_m + options_.body_radius_m);
  const double heading_rad = heading_to(here, plan_.touch_plan);
  const Vector2d end = Pose{here, heading_rad}.place_of({further_m, 0});
  const double narrow_m = floor.narrow_m_at(here, options_.plan.narrow_radius_m);
  if (further_m >= kLegEnd_m && !is_clear(*floor.grid(), here, end, narrow_m)) return std::nullopt;
  return GoalBearing{turn_rad(pose.heading_rad, heading_rad), bearing.distance_m};
}

}  // namespace roomwise::guide
