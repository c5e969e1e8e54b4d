#include <algorithm>
#include <limits>

#include "laboratory/simulation/home/ground_truth.h"
#include "laboratory/simulation/home/home_geometry.h"
#include "laboratory/trials/truth_evaluation.h"
#include "roomwise/pipeline/rooms/home_layout.h"

namespace roomwise::trials {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSameDoor_m = 1.0;

Vector2d on_floor(const geometry::RigidTransform& to_from, const Vector2d& point) {
  return (to_from * Vector3d(point.x(), point.y(), 0)).head<2>();
}

void count_floor(const pipeline::HomeLayout& home, const simulation::FloorPlanTruth& plan,
                 const geometry::RigidTransform& truth_from_gravity, LayoutEvaluation& result) {
  const double cell_m2 = home.grid.cell_m() * home.grid.cell_m();
  for (int row = 0; row < home.grid.rows(); ++row) {
    for (int column = 0; column < home.grid.columns(); ++column) {
      if (home.grid.at(column, row) != fusion::FloorCell::kFree) continue;
      const Vector2d place = on_floor(truth_from_gravity, home.grid.cell_middle_m(column, row));
      const auto room = std::ranges::find_if(plan.rooms, [&](const simulation::Room& one) {
        return simulation::contains(one.interior, place);
      });
      if (room == plan.rooms.end()) continue;
      result.floor_m2 += cell_m2;
      const auto found = home.layout.room_of_cell(column, row);
      if (found && home.layout.rooms()[*found].name == room->name) result.right_floor_m2 += cell_m2;
    }
  }
}

// Each door takes the nearest doorway of its two rooms that is left.
void count_doors(const rooms::RoomLayout& layout, const simulation::FloorPlanTruth& plan,
                 const geometry::RigidTransform& gravity_from_truth, LayoutEvaluation& result) {
  const auto is_named = [&](const std::string& name) {
    return std::ranges::find(layout.rooms(), name, &rooms::RoomExtent::name) !=
           layout.rooms().end();
  };
  std::vector<const rooms::Doorway*> left;
  for (const rooms::Doorway& doorway : layout.doorways()) left.push_back(&doorway);
  for (const simulation::Door& door : plan.doors) {
    if (!door.other_room) continue;
    std::array names{plan.rooms[door.room].name, plan.rooms[*door.other_room].name};
    std::ranges::sort(names);
    if (!is_named(names[0]) || !is_named(names[1])) continue;
    ++result.doors;
    const Vector2d middle = on_floor(gravity_from_truth, door.opening.center);
    const auto distance_m = [&](const rooms::Doorway* doorway) {
      return doorway->rooms == names ? (doorway->middle_gravity - middle).norm()
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

}  // namespace

Expected<LayoutEvaluation> evaluate_layout(const home::Home& home,
                                           const std::filesystem::path& recording,
                                           pipeline::RunContext& run) {
  ROOMWISE_CHECK_OK(mapped_walk(home, recording));
  ROOMWISE_TRY(const simulation::FloorPlanTruth plan,
               simulation::read_floor_plan(recording / "floorplan.json"));
  ROOMWISE_TRY(const auto things, simulation::read_objects_truth(recording / "objects.json"));
  ROOMWISE_TRY(const geometry::RigidTransform truth_from_world, truth_from_map(home, recording));
  ROOMWISE_TRY(const pipeline::HomeLayout found, pipeline::build_home_layout(home, {}, run));
  const geometry::RigidTransform gravity_from_truth =
      found.frame.gravity_from_world * truth_from_world.inverse();

  LayoutEvaluation result;
  count_floor(found, plan, gravity_from_truth.inverse(), result);
  count_doors(found.layout, plan, gravity_from_truth, result);
  for (const simulation::ObjectTruth& thing : things) {
    if (thing.seen.empty()) continue;
    ++result.things;
    const Vector2d place = on_floor(gravity_from_truth, thing.center_m.head<2>());
    if (found.layout.room_at(place) == thing.room) ++result.right_things;
  }
  return result;
}

}  // namespace roomwise::trials
