#include "laboratory/trials/guidance/guided_home.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "laboratory/simulation/home/ground_truth.h"
#include "laboratory/simulation/home/home_geometry.h"
#include "laboratory/simulation/home/storeys.h"
#include "laboratory/simulation/walk/walk.h"
#include "laboratory/trials/true_objects.h"
#include "roomwise/base/random.h"
#include "roomwise/guide/way/floor_search.h"
#include "roomwise/guide/way/legs.h"

namespace roomwise::trials {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;
using simulation::Footprint;
using simulation::FreeSpace;
using simulation::HomeModel;

constexpr double kCaneReachesUpTo_m = 0.7;

guide::Outline outline_of(const Footprint& footprint) {
  return {footprint.center, 2 * footprint.half_size, footprint.yaw_rad};
}

// Nobody is led to a carpet or to a lamp at the ceiling.
bool is_goal(const simulation::ObjectTruth& object) {
  const double bottom_m = object.center_m.z() - object.size_m.z() / 2;
  return object.size_m.z() > simulation::kCarpetHeight && bottom_m < simulation::kBodyToHeight;
}

Expected<rooms::RoomLayout> layout_of(const HomeModel& home, const fusion::FloorGrid& floor,
                                      std::uint64_t seed) {
  simulation::WalkOptions options;
  options.seed = seed;
  ROOMWISE_TRY(const auto walk, simulation::plan_walk(home, options));
  const fusion::Storeys storeys = true_storeys(home);
  std::vector<rooms::WalkedPath> walks(1);
  std::optional<std::size_t> storey;
  for (const simulation::WalkPose& pose : walk) {
    const Eigen::Vector3d camera = storeys.plan_from_gravity(pose.world_from_camera.translation);
    const Vector2d place = camera.head<2>();
    if (storeys.stairs_at(place) != nullptr) continue;
    if (storey && *storey != storeys.at_plan(place)) walks.emplace_back();
    storey = storeys.at_plan(place);
    walks.back().push_back({place, home.rooms[pose.room].name});
  }
  ROOMWISE_TRY(rooms::RoomLayout layout, rooms::RoomLayout::make(floor, walks));
  for (const fusion::Staircase& stairs : storeys.stairs()) {
    layout.add_stairs(stairs.below_plan, stairs.above_plan);
  }
  return layout;
}

FreeSpace space_up_to(const HomeModel& home, double height_m) {
  return {simulation::floors_of(home),
          simulation::obstacles_of(home, simulation::kBodyFromHeight, height_m)};
}

std::string between_rooms(const HomeModel& home, const simulation::Door& door) {
  return fmt::format("the door between the {} and the {}", home.rooms[door.room].name,
                     home.rooms[*door.other_room].name);
}

// What covers a place of no floor.
std::string thing_at(const HomeModel& home, const Vector2d& place, std::size_t from_room) {
  const auto covers = [&](const Footprint& footprint) {
    return footprint.top_m > simulation::kBodyFromHeight &&
           footprint.bottom_m < simulation::kBodyToHeight &&
           footprint.grown(FreeSpace::kCellSize / 2).contains(place);
  };
  for (const simulation::PlacedObject& object : home.objects) {
    if (!covers(simulation::footprint_of(object))) continue;
    const simulation::PlacedObject* lowest = &object;
    while (lowest->stands_on) lowest = &home.objects[*lowest->stands_on];
    return lowest->name;
  }
  for (const simulation::Window& window : home.windows) {
    for (const Footprint& curtain : simulation::curtains_of(window, home.wall_thickness_m)) {
      if (covers(curtain)) return fmt::format("curtain of the {}", home.rooms[window.room].name);
    }
  }
  for (const simulation::Door& door : home.doors) {
    if (!door.other_room) continue;
    const auto leaf = simulation::leaf_of(door, home.wall_thickness_m);
    if (leaf && covers(*leaf)) return "leaf of " + between_rooms(home, door);
    const simulation::Rectangle hole = simulation::hole_of(door.opening, home.wall_thickness_m);
    if (simulation::as_footprint(hole, 0, 0).distance_m(place) < FreeSpace::kCellSize) {
      return "frame of " + between_rooms(home, door);
    }
  }
  const simulation::Room& room = home.rooms[from_room];
  const Vector2d below = room.interior.min - place, above = place - room.interior.max;
  const double beyond_m = std::max(below.maxCoeff(), above.maxCoeff());
  if (beyond_m < 0) return "stairs";  // nothing else is no floor within a room
  const char* const side = beyond_m == below.x()   ? "left"
                           : beyond_m == above.x() ? "right"
                           : beyond_m == below.y() ? "lower"
                                                   : "upper";
  return fmt::format("{} wall of the {}", side, room.name);
}

class GoalChooser {
 public:
  GoalChooser(const GuidedMap& map, const WalkedHome& home, const GoalOptions& options)
      : map_(map), home_(home), options_(options), random_(options.seed, {0x676f616c}) {
    if (options_.by_name) name_things();
  }

  [[nodiscard]] std::vector<GuidedGoal> choose() {
    std::vector<GuidedGoal> goals;
    constexpr std::size_t kTries = 50;  // for each
    for (std::size_t i = 0; i < kTries * options_.goals && goals.size() < options_.goals; ++i) {
      std::optional<GuidedGoal> goal = draw_goal();
      if (!goal) continue;
      if (!find_stand(*goal)) continue;
      goal->start = free_place();
      goal->start_heading_rad = random_.between(-std::numbers::pi, std::numbers::pi);
      const auto shortest_m = shortest_way_m(home_, *goal, options_);
      if (!shortest_m || *shortest_m < options_.min_way_m) continue;
      goal->shortest_m = *shortest_m;
      const Vector2d end = goal->outline
                               ? goal->outline->middle_plan
                               : simulation::center(home_.model.rooms[*goal->room].interior);
      goal->is_over_stairs = home_.storeys.at_plan(end) != home_.storeys.at_plan(goal->start);
      goals.push_back(*std::move(goal));
    }
    return goals;
  }

 private:
  [[nodiscard]] std::optional<GuidedGoal> draw_goal() {
    const double kind = random_.uniform();
    constexpr double kThings = 0.75;  // as many of both as when there are doors and spots, too
    if (options_.by_name) return kind < kThings ? thing() : room();
    if (kind < 0.6) return thing();
    if (kind < 0.8) return room();
    if (kind < 0.9) return door();
    return kind < 0.95 ? way_out() : spot();
  }

  // Those that cannot be asked for get no word.
  void name_things() {
    static const objects::ObjectVocabulary vocabulary = objects::ObjectVocabulary::standard();
    std::map<std::pair<std::string, std::optional<std::string>>, int> counts;
    for (const guide::KnownThing& thing : map_.things) {
      words_.push_back(word_of(thing.name, vocabulary).value_or(""));
      ++counts[{words_.back(), thing.room}];
    }
    for (std::size_t i = 0; i < words_.size(); ++i) {
      if (counts[{words_[i], map_.things[i].room}] > 1) words_[i].clear();
    }
  }

  // Of those that still stand where the map has them.
  [[nodiscard]] std::optional<GuidedGoal> thing() {
    if (map_.things.empty()) return std::nullopt;
    const std::size_t i = random_.index(map_.things.size());
    if (options_.by_name && words_[i].empty()) return std::nullopt;
    const std::string& name = map_.object_of_thing[i];
    const auto now = std::ranges::find(home_.model.objects, name, &simulation::PlacedObject::name);
    if (now == home_.model.objects.end()) return std::nullopt;
    const Footprint footprint = simulation::footprint_of(*now);
    GuidedGoal goal{guide::Goal::of(map_.things[i], std::nullopt), outline_of(footprint),
                    now->room};
    if (options_.by_name) goal.word = words_[i];
    constexpr double kMoved_m = 0.2;
    if ((footprint.center - goal.goal.outline->middle_plan).norm() > kMoved_m) {
      return std::nullopt;
    }
    return goal;
  }
  [[nodiscard]] std::optional<GuidedGoal> room() {
    const std::size_t i = random_.index(map_.layout.rooms().size());
    const rooms::RoomExtent& extent = map_.layout.rooms()[i];
    const auto now = std::ranges::find(home_.model.rooms, extent.name, &simulation::Room::name);
    GuidedGoal goal{
        guide::Goal::of(extent), {}, static_cast<std::size_t>(now - home_.model.rooms.begin())};
    goal.word = extent.name;
    return goal;
  }
  [[nodiscard]] std::optional<GuidedGoal> door() {
    const auto doors = guide::doors_of(map_.layout.doorways());
    if (doors.empty()) return std::nullopt;
    const rooms::Doorway& door = doors[random_.index(doors.size())];
    // Who is between its jambs, or before them, is at the door.
    return GuidedGoal{guide::Goal::of(door), guide::Goal::of(door).outline};
  }
  [[nodiscard]] std::optional<GuidedGoal> way_out() {
    if (!map_.way_out) return std::nullopt;
    GuidedGoal goal;
    goal.goal.kind = guide::Goal::Kind::kWayOut;
    goal.goal.noun = {guide::Noun::Kind::kThing, "way out"};
    goal.goal.outline = map_.way_out;
    goal.goal.room = map_.way_out_room;
    goal.outline = map_.way_out;
    return goal;
  }
  [[nodiscard]] std::optional<GuidedGoal> spot() {
    GuidedGoal goal;
    goal.goal.kind = guide::Goal::Kind::kSpot;
    goal.goal.noun = {guide::Noun::Kind::kThing, "spot"};
    goal.goal.outline = guide::Outline{free_place()};
    goal.goal.room = map_.layout.room_at(goal.goal.outline->middle_plan);
    goal.outline = goal.goal.outline;
    return goal;
  }

  // False where nobody can stand anywhere near.
  [[nodiscard]] bool find_stand(GuidedGoal& goal) const {
    if (!goal.outline) return true;
    constexpr double kArm_m = 1;
    double nearest_m = kArm_m;
    const fusion::FloorGrid& floor = home_.floor;
    for (int row = 0; row < floor.rows(); ++row) {
      for (int column = 0; column < floor.columns(); ++column) {
        if (!floor.fits(column, row, options_.body_radius_m)) continue;
        const Vector2d place = floor.cell_middle_m(column, row);
        if (goal.room && simulation::room_at(home_.model, place) != *goal.room) continue;
        nearest_m = std::min(nearest_m, goal.outline->distance_m(place));
      }
    }
    goal.nearest_stand_m = nearest_m;
    return nearest_m < kArm_m;
  }

  [[nodiscard]] Vector2d free_place() {
    const fusion::FloorGrid& floor = home_.floor;
    while (true) {
      const auto column =
          static_cast<int>(random_.index(static_cast<std::uint64_t>(floor.columns())));
      const auto row = static_cast<int>(random_.index(static_cast<std::uint64_t>(floor.rows())));
      if (floor.fits(column, row, simulation::kWalkingRadius))
        return floor.cell_middle_m(column, row);
    }
  }

  const GuidedMap& map_;
  const WalkedHome& home_;
  const GoalOptions& options_;
  RandomStream random_;
  std::vector<std::string> words_;  // of the map's things, where goals are asked for by name
};

}  // namespace

Expected<void> GoalOptions::validate() const {
  if (goals == 0) return fail("goals is 0; expected 1 or more");
  if (!(arrived_m > 0 && body_radius_m > 0 && min_way_m > 0)) {
    return fail("arrived_m is {}, body_radius_m {} and min_way_m {}; expected more than 0",
                arrived_m, body_radius_m, min_way_m);
  }
  return {};
}

fusion::FloorGrid grid_of(const FreeSpace& space) {
  image::Image<fusion::FloorCell> cells(space.columns(), space.rows(),
                                        fusion::FloorCell::kOccupied);
  for (int row = 0; row < space.rows(); ++row) {
    for (int column = 0; column < space.columns(); ++column) {
      if (space.clearance_m(column, row) > 0) cells.at(column, row) = fusion::FloorCell::kFree;
    }
  }
  return {space.origin(), FreeSpace::kCellSize, std::move(cells)};
}

fusion::Storeys true_storeys(const HomeModel& home) {
  if (home.storeys.size() < 2) return {};
  std::vector<fusion::Storey> storeys;
  for (std::size_t i = 0; i < home.storeys.size(); ++i) {
    const Eigen::Vector3d& world_from_plan = home.storeys[i].world_from_plan;
    fusion::Storey& storey = storeys.emplace_back();
    storey.floor_m = world_from_plan.z();
    storey.plan_from_gravity = -world_from_plan.head<2>();
    if (i == 0) continue;
    double from_x = std::numeric_limits<double>::infinity();
    for (const simulation::Room& room : home.rooms) {
      if (room.storey == i) from_x = std::min(from_x, room.interior.min.x());
    }
    storey.plan_from_x_m = from_x - 1;  // in the gap between the plans
  }
  std::vector<fusion::Staircase> all;
  for (const simulation::Staircase& one : home.stairs) {
    fusion::Staircase& stairs = all.emplace_back();
    stairs.lower = home.rooms[one.lower_room].storey;
    stairs.below_plan = simulation::place_below(one);
    stairs.above_plan = simulation::place_above(home, one);
    stairs.foot_gravity = one.foot + home.storeys[stairs.lower].world_from_plan.head<2>();
    stairs.top_gravity = stairs.foot_gravity + one.run_m() * one.up;
    stairs.up_rad = stairs.end_rad = std::atan2(one.up.y(), one.up.x());
    stairs.run_m = one.run_m();
    stairs.height_m = one.height_m();
    stairs.steps = one.steps;
    stairs.width_m = one.width_m;
    stairs.has_left_rail = one.has_left_rail;
    stairs.has_right_rail = one.has_right_rail;
  }
  return fusion::Storeys(std::move(storeys), std::move(all));
}

WalkedHome::WalkedHome(const HomeModel& home)
    : model(home),
      floor(grid_of(FreeSpace::of(home))),
      cane(grid_of(space_up_to(home, kCaneReachesUpTo_m))),
      storeys(true_storeys(home)) {}

std::string WalkedHome::nearest_thing(const Vector2d& place) const {
  constexpr double kReach_m = 0.4;
  double nearest_m = kReach_m;
  Vector2d nearest = place;
  for (int row = 0; row < floor.rows(); ++row) {
    for (int column = 0; column < floor.columns(); ++column) {
      const Vector2d cell = floor.cell_middle_m(column, row);
      const double distance_m = (cell - place).norm();
      if (distance_m >= nearest_m || floor.at(column, row) == fusion::FloorCell::kFree) continue;
      nearest_m = distance_m;
      nearest = cell;
    }
  }
  return thing_at(model, nearest, simulation::room_at(model, place));
}

Expected<GuidedMap> map_truth(const HomeModel& home,
                              std::span<const simulation::FurnitureModel> models,
                              std::uint64_t seed) {
  fusion::FloorGrid floor = grid_of(FreeSpace::of(home));
  ROOMWISE_TRY(rooms::RoomLayout layout, layout_of(home, floor, seed));
  GuidedMap map{std::move(floor), std::move(layout), {}, {}, std::nullopt};
  map.storeys = true_storeys(home);
  const auto objects =
      simulation::objects_truth(home, models, simulation::ObservationCounter(home.objects.size()));
  for (std::size_t i = 0; i < objects.size(); ++i) {
    if (!is_goal(objects[i])) continue;
    guide::KnownThing& thing = map.things.emplace_back();
    thing.name = objects[i].label;
    thing.probability = 1;
    thing.position_plan = objects[i].center_m;
    thing.box_keyframe.size_m = objects[i].size_m;
    thing.yaw_rad = objects[i].yaw_rad;
    thing.room = objects[i].room;
    map.object_of_thing.push_back(objects[i].name);
  }
  for (const simulation::Door& door : home.doors) {
    if (door.other_room) continue;
    const simulation::Rectangle hole = simulation::hole_of(door.opening, home.wall_thickness_m);
    map.way_out = guide::Outline{simulation::center(hole), simulation::size(hole)};
    map.way_out_room = home.rooms[door.room].name;
  }
  return map;
}

bool is_there(const HomeModel& home, const GuidedGoal& goal, const Vector2d& place,
              const GoalOptions& options) {
  if (goal.room && simulation::room_at(home, place) != *goal.room) return false;
  if (!goal.outline) return contains(home.rooms[*goal.room].interior, place);
  return goal.outline->distance_m(place) <= goal.nearest_stand_m + options.arrived_m;
}

std::optional<double> shortest_way_m(const WalkedHome& home, const GuidedGoal& goal,
                                     const GoalOptions& options) {
  guide::FloorSearch search(home.floor, options.body_radius_m, options.body_radius_m);
  search.lead_over(home.storeys.stairs());
  const auto from =
      search.nearest_free(goal.start, home.floor.cell_m(), [](const Vector2d&) { return true; });
  if (!from) return std::nullopt;
  const auto way = search.find(*from, [&](const Vector2d& place) {
    return is_there(home.model, goal, place, options) ? std::optional(0.0) : std::nullopt;
  });
  if (way.empty()) return std::nullopt;
  return guide::length_m(search.straightened(way, options.body_radius_m), home.storeys.stairs());
}

Expected<std::vector<GuidedGoal>> choose_goals(const GuidedMap& map, const WalkedHome& home,
                                               const GoalOptions& options) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  std::vector<GuidedGoal> goals = GoalChooser(map, home, options).choose();
  if (goals.empty()) return fail("the home has no goal that a person can reach");
  return goals;
}

}  // namespace roomwise::trials
