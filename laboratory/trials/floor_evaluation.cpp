#include <Eigen/Geometry>
#include <cmath>

#include "laboratory/simulation/home/ground_truth.h"
#include "laboratory/trials/truth_evaluation.h"
#include "roomwise/pipeline/mapping/dense_map.h"
#include "roomwise/pipeline/mapping/gravity_aligned_map.h"

namespace roomwise::trials {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

evaluation::StandingRoom true_cells(const simulation::FreeSpaceTruth& truth) {
  evaluation::StandingRoom free(static_cast<int>(truth.rows.front().size()),
                                static_cast<int>(truth.rows.size()));
  for (int row = 0; row < free.height(); ++row) {
    const std::string& cells = truth.rows[static_cast<std::size_t>(row)];
    for (int column = 0; column < free.width(); ++column) {
      const auto place = static_cast<std::size_t>(column);
      free.at(column, row) = place < cells.size() && cells[place] == '.' ? 1 : 0;
    }
  }
  return free;
}

// What the map says of the middles of the truth's cells.
evaluation::StandingRoom found_cells(const simulation::FloorPlanTruth& plan,
                                     const fusion::FloorGrid& grid, const fusion::Storeys& storeys,
                                     const geometry::RigidTransform& gravity_from_truth,
                                     int columns, int rows) {
  const simulation::FreeSpaceTruth& truth = plan.free_space;
  evaluation::StandingRoom free(columns, rows);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Vector2d middle = truth.origin_m + truth.cell_m * Vector2d(column + 0.5, row + 0.5);
      const Vector3d point_gravity = gravity_from_truth * plan.world_from_plan(middle);
      const Vector3d point_plan = storeys.plan_from_gravity(point_gravity);
      free.at(column, row) = grid.fits(point_plan.head<2>(), truth.person_radius_m) ? 1 : 0;
    }
  }
  return free;
}

}  // namespace

Expected<FloorEvaluation> evaluate_floor(const home::Home& home,
                                         const std::filesystem::path& recording,
                                         pipeline::RunContext& run) {
  ROOMWISE_RETURN_IF_ERROR(mapped_walk(home, recording));
  ROOMWISE_TRY(const simulation::FloorPlanTruth plan,
               simulation::read_floor_plan(recording / "floorplan.json"));
  const simulation::FreeSpaceTruth& truth = plan.free_space;
  if (truth.rows.empty()) {
    return fail("{}: has no free space", (recording / "floorplan.json").string());
  }
  ROOMWISE_TRY(const geometry::RigidTransform truth_from_world, truth_from_map(home, recording));
  ROOMWISE_TRY(const pipeline::GravityAlignedMap map,
               pipeline::build_gravity_aligned_map(home, {.keeps_colors = false}, run));
  ROOMWISE_TRY(const fusion::FloorGrid grid, pipeline::floor_grid_of(map, {}, run));
  const geometry::RigidTransform gravity_from_truth =
      map.frame.gravity_from_world * truth_from_world.inverse();

  const evaluation::StandingRoom is_true = true_cells(truth);
  const evaluation::StandingRoom is_found = found_cells(
      plan, grid, map.frame.storeys, gravity_from_truth, is_true.width(), is_true.height());
  FloorEvaluation result;
  ROOMWISE_TRY(result.error, evaluation::floor_error(is_true, is_found, truth.cell_m));
  const Vector2d middle =
      truth.origin_m + truth.cell_m / 2 * Vector2d(is_true.width(), is_true.height());
  result.floor_above_truth_m = -(gravity_from_truth * Vector3d(middle.x(), middle.y(), 0)).z();
  const Vector3d up = gravity_from_truth.rotation * Vector3d::UnitZ();
  result.tilt_rad = std::atan2(up.head<2>().norm(), up.z());
  return result;
}

}  // namespace roomwise::trials
