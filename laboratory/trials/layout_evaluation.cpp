#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "laboratory/simulation/home/ground_truth.h"
#include "laboratory/simulation/home/home_geometry.h"
#include "laboratory/trials/truth_evaluation.h"
#include "roomwise/pipeline/rooms/home_layout.h"

namespace roomwise::trials {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSameDoor_m = 1.0;

// From the truth's plan to the map's and back; of one storey both are the level frames.
struct PlanPair {
  const simulation::FloorPlanTruth& truth;
  const fusion::Storeys& storeys;
  geometry::RigidTransform gravity_from_truth;

  [[nodiscard]] Vector2d map_from_truth(const Vector3d& place_world) const {
    return storeys.plan_from_gravity(gravity_from_truth * place_world).head<2>();
  }
  [[nodiscard]] Vector2d truth_from_map(const Vector2d& place) const {
    return truth.plan_from_world(gravity_from_truth.inverse() *
                                 storeys.gravity_from_plan({place.x(), place.y(), 0}));
  }
};

void count_floor(const pipeline::HomeLayout& home, const PlanPair& plans,
                 LayoutEvaluation& result) {
  const double cell_m2 = home.grid.cell_m() * home.grid.cell_m();
  for (int row = 0; row < home.grid.rows(); ++row) {
    for (int column = 0; column < home.grid.columns(); ++column) {
      if (home.grid.at(column, row) != fusion::FloorCell::kFree) continue;
      const Vector2d place = plans.truth_from_map(home.grid.cell_middle_m(column, row));
      const auto room = std::ranges::find_if(plans.truth.rooms, [&](const simulation::Room& one) {
        return simulation::contains(one.interior, place);
      });
      if (room == plans.truth.rooms.end()) continue;
      result.floor_m2 += cell_m2;
      const bool is_open = room->open_floor && simulation::contains(*room->open_floor, place);
      if (is_open) result.open_floor_m2 += cell_m2;
      const auto found = home.layout.room_of_cell(column, row);
      if (found && home.layout.rooms()[*found].name == room->name) result.right_floor_m2 += cell_m2;
    }
  }
}

// Each door takes the nearest doorway of its two rooms that is left.
void count_doors(const rooms::RoomLayout& layout, const PlanPair& plans, LayoutEvaluation& result) {
  const auto is_named = [&](const std::string& name) {
    return std::ranges::find(layout.rooms(), name, &rooms::RoomExtent::name) !=
           layout.rooms().end();
  };
  std::vector<const rooms::Doorway*> left;
  for (const rooms::Doorway& doorway : layout.doorways()) {
    if (!doorway.is_stairs) left.push_back(&doorway);
  }
  const auto& rooms = plans.truth.rooms;
  for (const simulation::Door& door : plans.truth.doors) {
    if (!door.other_room) continue;
    std::array names{rooms[door.room].name, rooms[*door.other_room].name};
    std::ranges::sort(names);
    if (!is_named(names[0]) || !is_named(names[1])) continue;
    ++result.doors;
    const Vector2d middle = plans.map_from_truth(plans.truth.world_from_plan(door.opening.center));
    const auto distance_m = [&](const rooms::Doorway* doorway) {
      return doorway->rooms == names ? (doorway->middle_plan - middle).norm()
                                     : std::numeric_limits<double>::infinity();
    };
    const auto nearest = std::ranges::min_element(left, {}, distance_m);
    if (nearest == left.end() || distance_m(*nearest) > kSameDoor_m) continue;
    ++result.found_doors;
    result.door_errors_m.push_back(distance_m(*nearest));
    left.erase(nearest);
  }
  result.false_doorways = left.size();
}

// Each of the truth's stairs takes those whose first riser is nearest.
void measure_stairs(const PlanPair& plans, LayoutEvaluation& result) {
  result.storeys = plans.truth.storeys.size();
  result.found_storeys = plans.storeys.count();
  result.found_stairs = plans.storeys.stairs().size();
  for (const simulation::Staircase& one : plans.truth.stairs) {
    StairsError& error = result.stairs.emplace_back();
    error.steps = one.steps;
    const auto in_gravity = [&](double along_m) {
      const Vector2d place = one.foot + along_m * one.up;
      const Vector3d world =
          Vector3d(place.x(), place.y(), 0) +
          plans.truth.storeys[plans.truth.rooms[one.lower_room].storey].world_from_plan;
      return Vector2d((plans.gravity_from_truth * world).head<2>());
    };
    const Vector2d foot = in_gravity(0), top = in_gravity(one.run_m());
    const auto foot_error_m = [&](const fusion::Staircase& found) {
      return (found.foot_gravity - foot).norm();
    };
    const auto& all = plans.storeys.stairs();
    const auto found = std::ranges::min_element(all, {}, foot_error_m);
    if (found == all.end()) continue;
    error.is_found = true;
    error.found_steps = found->steps;
    error.foot_m = foot_error_m(*found);
    error.top_m = (found->top_gravity - top).norm();
    error.width_m = found->width_m - one.width_m;
    const Vector2d up = top - foot;
    error.heading_rad =
        std::abs(std::remainder(found->up_rad - std::atan2(up.y(), up.x()), 2 * std::numbers::pi));
    error.are_rails_right =
        found->has_left_rail == one.has_left_rail && found->has_right_rail == one.has_right_rail;
  }
}

}  // namespace

Expected<LayoutEvaluation> evaluate_layout(const home::Home& home,
                                           const std::filesystem::path& recording,
                                           pipeline::RunContext& run) {
  ROOMWISE_RETURN_IF_ERROR(mapped_walk(home, recording));
  ROOMWISE_TRY(const simulation::FloorPlanTruth plan,
               simulation::read_floor_plan(recording / "floorplan.json"));
  ROOMWISE_TRY(const auto things, simulation::read_objects_truth(recording / "objects.json"));
  ROOMWISE_TRY(const geometry::RigidTransform truth_from_world, truth_from_map(home, recording));
  ROOMWISE_TRY(const pipeline::HomeLayout found, pipeline::build_home_layout(home, {}, run));
  const PlanPair plans{plan, found.frame.storeys,
                       found.frame.gravity_from_world * truth_from_world.inverse()};

  LayoutEvaluation result;
  count_floor(found, plans, result);
  count_doors(found.layout, plans, result);
  measure_stairs(plans, result);
  for (const simulation::ObjectTruth& thing : things) {
    if (thing.seen.empty()) continue;
    ++result.things;
    // On its storey's floor.
    const Vector3d floor = plan.world_from_plan(plan.plan_from_world(thing.center_m));
    if (found.layout.room_at(plans.map_from_truth(floor)) == thing.room) ++result.right_things;
  }
  return result;
}

}  // namespace roomwise::trials
