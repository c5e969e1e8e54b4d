#include "laboratory/simulation/walk/walk_route.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

#include "laboratory/simulation/home/free_space.h"
#include "laboratory/simulation/home/home_geometry.h"
#include "laboratory/simulation/home/storeys.h"
#include "laboratory/simulation/walk/viewpoints.h"

namespace roomwise::simulation {
namespace {

// Rounds the corners of a way along cells, as far as it stays clear of things.
std::vector<Eigen::Vector2d> smoothed(const std::vector<Eigen::Vector2d>& way,
                                      const FreeSpace& space) {
  for (const int reach : {10, 6, 3, 1}) {
    std::vector<Eigen::Vector2d> result = way;
    for (int pass = 0; pass < 2; ++pass) {
      const std::vector<Eigen::Vector2d> before = result;
      const int count = static_cast<int>(before.size());
      for (int i = 0; i < count; ++i) {
        const int span = std::min({reach, i, count - 1 - i});  // the ends stay
        Eigen::Vector2d sum = Eigen::Vector2d::Zero();
        for (int j = i - span; j <= i + span; ++j) sum += before[static_cast<std::size_t>(j)];
        result[static_cast<std::size_t>(i)] = sum / (2 * span + 1);
      }
    }
    const bool is_clear = std::ranges::all_of(result, [&](const Eigen::Vector2d& point) {
      return space.clearance_m(point) >= kWalkingRadius;
    });
    if (is_clear) return result;
  }
  return way;
}

class RoutePlanner {
 public:
  RoutePlanner(const HomeModel& home, const WalkOptions& options)
      : home_(home),
        options_(options),
        space_(FreeSpace::of(home)),
        random_(options.seed, {home.seed, 0x726f757465}) {}

  Expected<Route> plan() {
    ROOMWISE_TRY(const std::vector<std::size_t> rooms, rooms_to_visit());
    ROOMWISE_RETURN_IF_ERROR(find_start(rooms.front()));
    bool has_shown_wall = false;
    for (std::size_t i = 0; i < rooms.size(); ++i) {
      ROOMWISE_RETURN_IF_ERROR(visit(rooms[i], i));
      const bool is_time = i + 1 == rooms.size() || random_.uniform() < 0.5;
      if (!has_shown_wall && is_time) has_shown_wall = look_at_bare_wall();
    }
    ROOMWISE_RETURN_IF_ERROR(go_over_stairs(rooms.front()));
    ROOMWISE_RETURN_IF_ERROR(go_to(route_.start, "the start"));
    route_.legs.back().gazes.push_back({route_.start_heading_rad, 0.15, 0.6});
    return std::move(route_);
  }

 private:
  // By name, or all: from the front door, into each room from one that was seen before.
  Expected<std::vector<std::size_t>> rooms_to_visit() {
    std::vector<std::size_t> rooms;
    for (const std::string& name : options_.rooms) {
      const auto room = std::ranges::find(home_.rooms, name, &Room::name);
      if (room == home_.rooms.end()) return fail("the home has no room '{}' to walk through", name);
      rooms.push_back(static_cast<std::size_t>(room - home_.rooms.begin()));
    }
    if (rooms.empty()) {
      std::vector<bool> seen(home_.rooms.size());
      add_rooms_behind(first_room(), seen, rooms);
      for (std::size_t i = 0; i < seen.size(); ++i) {
        if (!seen[i]) return fail("no door leads to the {}", home_.rooms[i].name);
      }
    }
    return rooms;
  }

  [[nodiscard]] std::size_t first_room() const {
    const auto front =
        std::ranges::find_if(home_.doors, [](const Door& door) { return !door.other_room; });
    return front == home_.doors.end() ? 0 : front->room;
  }

  void add_rooms_behind(std::size_t room, std::vector<bool>& seen,
                        std::vector<std::size_t>& order) {
    seen[room] = true;
    order.push_back(room);
    std::vector<std::size_t> next;
    for (const Door& door : home_.doors) {
      if (door.other_room && door.room == room) next.push_back(*door.other_room);
      if (door.other_room == room) next.push_back(door.room);
    }
    for (const Staircase& stairs : home_.stairs) {
      if (stairs.lower_room == room) next.push_back(stairs.upper_room);
      if (stairs.upper_room == room) next.push_back(stairs.lower_room);
    }
    std::ranges::sort(next);
    std::shuffle(next.begin(), next.end(), random_);
    for (const std::size_t other : next) {
      if (!seen[other]) add_rooms_behind(other, seen, order);
    }
  }

  // Inside the front door, looking into the home; in another first room in its middle.
  Expected<void> find_start(std::size_t room) {
    Eigen::Vector2d wish = center(home_.rooms[room].interior);
    if (room == first_room()) {
      for (const Door& door : home_.doors) {
        if (door.other_room) continue;
        const Eigen::Vector2d inward = wish - door.opening.center;
        wish = door.opening.center + inward.normalized() * std::min(0.9, inward.norm());
      }
    }
    const auto start = space_.nearest_free(wish, kWalkingRadius);
    if (!start) return fail("there is no place to stand in the {}", home_.rooms[room].name);
    route_.start = place_ = *start;
    reachable_ = space_.reachable_from(*start, kWalkingRadius);
    for (const Staircase& stairs : home_.stairs) {
      for (const Eigen::Vector2d& end : {place_below(stairs), place_above(home_, stairs)}) {
        const auto around = space_.reachable_from(end, kWalkingRadius);
        std::transform(reachable_.begin(), reachable_.end(), around.begin(), reachable_.begin(),
                       std::logical_or<>());
      }
    }
    const Eigen::Vector2d ahead = center(home_.rooms[room].interior) - place_;
    route_.start_heading_rad = std::atan2(ahead.y(), ahead.x());
    return {};
  }

  Expected<void> visit(std::size_t room, std::size_t turn) {
    std::vector<Viewpoint> views =
        choose_viewpoints(home_, room, space_, reachable_, kWalkingRadius);
    if (views.empty()) {
      return fail("the {} cannot be reached on foot; open its door or make room",
                  home_.rooms[room].name);
    }
    bool is_first = true;
    while (!views.empty()) {
      const auto next = std::ranges::min_element(
          views, {}, [&](const Viewpoint& view) { return (view.place - place_).norm(); });
      ROOMWISE_RETURN_IF_ERROR(go_over_stairs(room));
      ROOMWISE_RETURN_IF_ERROR(go_to(next->place, home_.rooms[room].name));
      // All around, once in a room; in every third one quickly.
      look_at(*next, is_first, options_.fast_turns && turn % 3 == 1);
      is_first = false;
      views.erase(next);
    }
    return {};
  }

  Expected<void> go_to(const Eigen::Vector2d& goal, std::string_view name) {
    const auto way = space_.path(place_, goal, kWalkingRadius);
    if (!way) return fail("no way leads to the {}; open its door or make room", name);
    add_leg(smoothed(*way, space_));
    if (way->size() > 1) {
      const Eigen::Vector2d last =
          way->back() - (*way)[way->size() - std::min<std::size_t>(way->size(), 8)];
      heading_ = std::atan2(last.y(), last.x());
    }
    place_ = way->back();
    return {};
  }

  // A way on the plan of the storey where one is.
  void add_leg(std::vector<Eigen::Vector2d> way) {
    const Eigen::Vector3d& from_plan = home_.storeys[storey()].world_from_plan;
    for (Eigen::Vector2d& place : way) place += from_plan.head<2>();
    Leg leg{std::move(way), {}, {}};
    if (storey() > 0) leg.floor_m.assign(leg.way.size(), from_plan.z());
    route_.legs.push_back(std::move(leg));
  }

  [[nodiscard]] std::size_t storey() const { return home_.rooms[room_at(home_, place_)].storey; }

  // To the storey of a room, where that is another one.
  Expected<void> go_over_stairs(std::size_t room) {
    constexpr double kStairsDown_rad = 0.45;  // one looks at the steps
    while (storey() != home_.rooms[room].storey) {
      const bool is_up = home_.rooms[room].storey > storey();
      const auto stairs = std::ranges::find_if(home_.stairs, [&](const Staircase& one) {
        return home_.rooms[is_up ? one.lower_room : one.upper_room].storey == storey();
      });
      if (stairs == home_.stairs.end()) {
        return fail("no stairs lead to the {}", home_.rooms[room].name);
      }
      const Eigen::Vector2d below = place_below(*stairs), above = place_above(home_, *stairs);
      ROOMWISE_RETURN_IF_ERROR(go_to(is_up ? below : above, "stairs"));
      const Eigen::Vector2d ahead = is_up ? stairs->up : Eigen::Vector2d(-stairs->up);
      heading_ = std::atan2(ahead.y(), ahead.x());
      route_.legs.back().gazes.push_back({heading_, is_up ? 0.15 : kStairsDown_rad, 0.3});
      StairsWay way = way_over(home_, *stairs);
      if (!is_up) {
        std::ranges::reverse(way.places);
        std::ranges::reverse(way.floor_m);
      }
      // From where the last way ended, which is a cell's middle.
      way.places.front() = route_.legs.back().way.back();
      route_.legs.push_back(
          {std::move(way.places), std::move(way.floor_m), {}, is_up ? 0.25 : kStairsDown_rad});
      place_ = is_up ? above : below;
    }
    return {};
  }

  // The objects from one side to the other, beginning on the nearer side; neighbours in one gaze.
  void look_at(const Viewpoint& view, bool all_around, bool is_fast) {
    struct Aim {
      double turn, down;
    };
    std::vector<Aim> aims;
    for (const std::size_t i : view.objects) {
      const PlacedObject& object = home_.objects[i];
      const Eigen::Vector3d middle =
          object.world_from_object * Eigen::Vector3d(0, 0, object.size_m.z() / 2);
      const Eigen::Vector2d offset = middle.head<2>() - view.place;
      constexpr double kMinDown = -0.25, kMaxDown = 0.45;
      const double down = std::atan2(options_.camera_height_m - middle.z(), offset.norm());
      aims.push_back({wrapped(std::atan2(offset.y(), offset.x()) - heading_),
                      std::clamp(down, kMinDown, kMaxDown)});
    }
    std::ranges::sort(aims, {}, &Aim::turn);
    if (!aims.empty() && std::abs(aims.back().turn) < std::abs(aims.front().turn)) {
      std::ranges::reverse(aims);
    }
    std::vector<Gaze>& gazes = route_.legs.back().gazes;
    const double begin = heading_;
    constexpr double kSameView = 0.5;
    for (std::size_t i = 0; i < aims.size();) {
      std::size_t end = i + 1;
      while (end < aims.size() && std::abs(aims[end].turn - aims[i].turn) < kSameView) ++end;
      Gaze gaze;
      for (std::size_t j = i; j < end; ++j) {
        gaze.heading_rad += aims[j].turn / static_cast<double>(end - i);
        gaze.down_rad += aims[j].down / static_cast<double>(end - i);
      }
      gaze.heading_rad += begin;
      gaze.down_rad -= Gaze{}.down_rad;
      gaze.hold_s = 0.1 + 0.2 * random_.uniform();
      gazes.push_back(gaze);
      i = end;
    }
    if (all_around) look_around(is_fast);
    if (!gazes.empty()) heading_ = gazes.back().heading_rad;
  }

  // Through what the gazes so far leave out of the circle.
  void look_around(bool is_fast) {
    std::vector<Gaze>& gazes = route_.legs.back().gazes;
    const double from = gazes.empty() ? heading_ : gazes.back().heading_rad;
    const double side = random_.uniform() < 0.5 ? -1 : 1;
    constexpr int kDirections = 6;
    for (int i = 1; i <= kDirections; ++i) {
      Gaze gaze;
      gaze.heading_rad = from + side * i * 2 * std::numbers::pi / kDirections;
      gaze.down_rad = 0.1 + 0.16 * random_.uniform();
      gaze.is_fast = is_fast && (i == 2 || i == 3);
      gazes.push_back(gaze);
    }
    gazes.back().hold_s = 0.2;
  }

  // Where a piece of wall fills the view: near, and with nothing before it.
  bool look_at_bare_wall() {
    const std::size_t room = room_at(home_, place_);
    constexpr int kDirections = 16;
    for (int i = 0; i < kDirections; ++i) {
      const double heading = heading_ + 2 * std::numbers::pi * i / kDirections;
      const bool is_bare = std::ranges::all_of(std::array{-0.4, 0.0, 0.4}, [&](double aside) {
        return sees_wall(room, heading + aside);
      });
      if (!is_bare) continue;
      route_.legs.back().gazes.push_back({heading, 0.05, 0.8});
      heading_ = heading;
      return true;
    }
    return false;
  }

  [[nodiscard]] bool sees_wall(std::size_t room, double heading) const {
    constexpr double kFarAhead = 1.6, kStep = 0.05;
    const Eigen::Vector2d direction(std::cos(heading), std::sin(heading));
    for (double distance = kStep; distance < kFarAhead; distance += kStep) {
      const Eigen::Vector2d point = place_ + direction * distance;
      if (!contains(home_.rooms[room].interior, point)) {
        return std::ranges::none_of(home_.doors, [&](const Door& door) {
          return contains(passage_of(door, home_.wall_thickness_m), point);
        });
      }
      const bool meets = std::ranges::any_of(home_.objects, [&](const PlacedObject& object) {
        return object.room == room && footprint_of(object).contains(point);
      });
      if (meets) return false;
    }
    return false;
  }

  const HomeModel& home_;
  const WalkOptions& options_;
  FreeSpace space_;
  RandomStream random_;
  Route route_;
  std::vector<bool> reachable_;
  Eigen::Vector2d place_ = Eigen::Vector2d::Zero();
  double heading_ = 0;
};

}  // namespace

double wrapped(double angle_rad) {
  return std::remainder(angle_rad, 2 * std::numbers::pi);
}

Expected<Route> plan_route(const HomeModel& home, const WalkOptions& options) {
  return RoutePlanner(home, options).plan();
}

}  // namespace roomwise::simulation
