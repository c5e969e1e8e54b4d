#include "roomwise/guide/way/plan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "roomwise/guide/way/floor_search.h"

namespace roomwise::guide {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;

constexpr double kInfinitelyFar = std::numeric_limits<double>::infinity();

// One search for a way on a known floor.
class Planner {
 public:
  Planner(const HomeMap& map, const Pose& pose, const Goal& goal, const PlanOptions& options)
      : map_(map),
        goal_(goal),
        options_(options),
        from_(pose.position_plan),
        here_(map.room_at(pose.position_plan)) {
    for (const rooms::Doorway& doorway : map.doorways) {
      if (goal.room && doorway.joins(*goal.room)) goal_doorways_.push_back(doorway);
    }
  }

  [[nodiscard]] std::optional<Plan> whole(double radius_m) const {
    auto plan = find(radius_m, [this](const Vector2d& place) { return end_cost(place); });
    if (plan) plan->status = PlanStatus::kComplete;
    return plan;
  }

  // To the reachable place with the fewest doors to the goal, and nearest to it of those.
  [[nodiscard]] std::optional<Plan> near(double radius_m) const {
    std::map<std::optional<std::string>, double> doors_left;
    const auto rest_m = [&](const Vector2d& place) {
      const auto room = map_.room_at(place);
      auto known = doors_left.find(room);
      if (known == doors_left.end()) known = doors_left.emplace(room, doors_to_goal(room)).first;
      // A door counts more than any distance within a home.
      constexpr double kDoor_m = 1000;
      return known->second * kDoor_m + target(room).distance_m(place);
    };
    Vector2d nearest = from_;
    double min_m = kInfinitelyFar;
    // Nowhere is an end, so it looks everywhere.
    (void)find(radius_m, [&](const Vector2d& place) -> std::optional<double> {
      if (const double left_m = rest_m(place); left_m < min_m) {
        min_m = left_m;
        nearest = place;
      }
      return std::nullopt;
    });
    if (min_m == kInfinitelyFar) return std::nullopt;
    auto plan = find(radius_m, [&](const Vector2d& place) {
      return place == nearest ? std::optional(0.0) : std::nullopt;
    });
    if (!plan) return std::nullopt;
    plan->status = PlanStatus::kPartial;
    const auto room = map_.room_at(plan->route.back());
    if (room && goal_.room && *room != *goal_.room) {
      plan->rooms = way_between_rooms(*room, *goal_.room, map_.doorways);
    }
    return plan;
  }

 private:
  [[nodiscard]] std::optional<Plan> find(double radius_m,
                                         const FloorSearch::EndCost& end_cost) const {
    const RouteOptions& person = options_.room_for_a_person;
    FloorSearch search(*map_.floor, radius_m, std::max(radius_m, person.comfort_m));
    if (map_.storeys != nullptr) search.lead_over(map_.storeys->stairs());
    const auto start = start_cell(search);
    if (!start) return std::nullopt;
    const std::vector<Vector2i> way = search.find(*start, end_cost);
    if (way.empty()) return std::nullopt;
    Plan plan;
    plan.route = search.straightened(way, std::max(radius_m, options_.straight_m));
    plan.is_narrow = radius_m < person.person_radius_m;
    plan.touch_plan = goal_.outline->nearest_to(plan.route.back());
    return plan;
  }

  // In the room that one stands in, rather than behind its wall.
  [[nodiscard]] std::optional<Vector2i> start_cell(const FloorSearch& search) const {
    const double farthest_m = options_.farthest_start_m;
    if (here_) {
      const auto start = search.nearest_free(
          from_, farthest_m, [&](const Vector2d& place) { return map_.room_at(place) == here_; });
      if (start) return start;
    }
    return search.nearest_free(from_, farthest_m, [](const Vector2d&) { return true; });
  }

  [[nodiscard]] std::optional<double> end_cost(const Vector2d& place) const {
    if (goal_.kind == Goal::Kind::kRoom) return room_end_cost(place);
    const double distance_m = goal_.outline->distance_m(place);
    if (distance_m > options_.arm_m) return std::nullopt;
    const bool knows_room = map_.layout != nullptr && goal_.room;
    const bool any_side = goal_.kind == Goal::Kind::kDoor;
    const bool must_be_inside = knows_room && !any_side;
    if (must_be_inside && map_.room_at(place) != goal_.room) return std::nullopt;
    // An arm reaches through no wall.
    if (any_side && map_.layout != nullptr && !is_in_room_of_door(place)) return std::nullopt;
    // Rather a little farther from it than between two rooms.
    constexpr double kBetween_m = 0.3;
    const bool is_between = must_be_inside && !is_well_inside(map_, *goal_.room, place);
    return options_.reach_weight * (distance_m + (is_between ? kBetween_m : 0));
  }

  [[nodiscard]] bool is_in_room_of_door(const Vector2d& place) const {
    const auto room = map_.room_at(place);
    return room && std::ranges::any_of(map_.doorways, [&](const rooms::Doorway& doorway) {
             return doorway.middle_plan == goal_.outline->middle_plan && doorway.joins(*room);
           });
  }

  // Inside, beyond the door; where the room is smaller than that, as far in as there is floor.
  [[nodiscard]] std::optional<double> room_end_cost(const Vector2d& place) const {
    if (map_.room_at(place) != goal_.room) return std::nullopt;
    double from_door_m = options_.into_room_m;
    for (const rooms::Doorway& doorway : goal_doorways_) {
      from_door_m = std::min(from_door_m, (place - doorway.place_in(*goal_.room)).norm());
    }
    if (!is_well_inside(map_, *goal_.room, place)) from_door_m = 0;
    constexpr double kShallow = 10;  // a metre less deep
    return kShallow * (options_.into_room_m - from_door_m);
  }

  [[nodiscard]] double doors_to_goal(const std::optional<std::string>& room) const {
    if (!goal_.room || map_.layout == nullptr || room == goal_.room) return 0;
    const auto way =
        room ? way_between_rooms(*room, *goal_.room, map_.doorways) : std::vector<std::string>{};
    return way.empty() ? static_cast<double>(map_.layout->rooms().size())
                       : static_cast<double>(way.size() - 1);
  }

  // What lies on the way in this room: the goal, or the doorway to the next room.
  [[nodiscard]] Outline target(const std::optional<std::string>& room) const {
    if (!room || !goal_.room || room == goal_.room) return *goal_.outline;
    const auto way = way_between_rooms(*room, *goal_.room, map_.doorways);
    if (way.size() < 2) return *goal_.outline;
    for (const rooms::Doorway& doorway : map_.doorways) {
      if (doorway.joins(way[0]) && doorway.joins(way[1])) return {doorway.place_in(*room)};
    }
    return *goal_.outline;
  }

  const HomeMap& map_;
  const Goal& goal_;
  const PlanOptions& options_;
  Vector2d from_;
  std::optional<std::string> here_;
  std::vector<rooms::Doorway> goal_doorways_;
};

Plan by_rooms(const HomeMap& map, const UserLocation& from, const Goal& goal, std::string because) {
  Plan plan;
  plan.because = std::move(because);
  std::optional<std::string> here = from.room;
  if (!here && from.sure_pose() != nullptr) here = map.room_at(from.pose->position_plan);
  if (!here || !goal.room) return plan;
  if (*here != *goal.room) {
    plan.rooms = way_between_rooms(*here, *goal.room, map.doorways);
    if (plan.rooms.empty()) return plan;
  }
  plan.status = PlanStatus::kRoomsOnly;
  return plan;
}

// By rooms, or else by a step at least.
bool gets_nearer(const Plan& plan, const Plan& other) {
  constexpr double kStep_m = 0.7;
  if (plan.rooms.size() != other.rooms.size()) return plan.rooms.size() < other.rooms.size();
  return (plan.touch_plan - plan.route.back()).norm() <
         (other.touch_plan - other.route.back()).norm() - kStep_m;
}

}  // namespace

Expected<void> PlanOptions::validate() const {
  ROOMWISE_RETURN_IF_ERROR(room_for_a_person.validate());
  if (!(narrow_radius_m > 0 && narrow_radius_m <= room_for_a_person.person_radius_m)) {
    return fail("narrow_radius_m is {}; expected more than 0, at most person_radius_m, {}",
                narrow_radius_m, room_for_a_person.person_radius_m);
  }
  if (!(farthest_start_m > 0 && arm_m > 0 && straight_m > 0 && reach_weight >= 0 &&
        into_room_m >= 0)) {
    return fail(
        "farthest_start_m is {}, arm_m {}, straight_m {}, reach_weight {} and into_room_m {}; "
        "expected more than 0, and 0 at least for the last two",
        farthest_start_m, arm_m, straight_m, reach_weight, into_room_m);
  }
  return {};
}

Plan plan_way(const HomeMap& map, const UserLocation& from, const Goal& goal,
              const PlanOptions& options) {
  if (const auto valid = options.validate(); !valid) return {.because = valid.error().message};
  const Pose* pose = from.sure_pose();
  if (pose == nullptr) return by_rooms(map, from, goal, "nobody knows where the way begins");
  if (!goal.outline) return by_rooms(map, from, goal, "the map does not know where the goal is");
  if (map.floor == nullptr) return by_rooms(map, from, goal, "the map shows no floor");
  const Planner planner(map, *pose, goal, options);
  const double wide_m = options.room_for_a_person.person_radius_m;
  for (const double radius_m : {wide_m, options.narrow_radius_m}) {
    if (auto plan = planner.whole(radius_m)) return *std::move(plan);
  }
  const char* const why = "no free floor that is wide enough leads to the goal";
  auto plan = planner.near(wide_m);
  auto narrow = planner.near(options.narrow_radius_m);
  if (!plan || (narrow && gets_nearer(*narrow, *plan))) plan = std::move(narrow);
  if (plan) {
    plan->because = why;
    return *std::move(plan);
  }
  return by_rooms(map, from, goal, "no free floor is known where the way begins");
}

}  // namespace roomwise::guide
