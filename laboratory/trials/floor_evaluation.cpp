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

int columns_of(const simulation::FreeSpaceTruth& truth) {
  return static_cast<int>(truth.rows.front().size());
}
int rows_of(const simulation::FreeSpaceTruth& truth) {
  return static_cast<int>(truth.rows.size());
}

// Cells of the truth, and such cells beyond where the map has free floor: nobody stands there.
struct ComparedCells {
  Eigen::Array2i first, last;  // column, row

  [[nodiscard]] evaluation::StandingRoom nowhere() const {
    return {last.x() - first.x() + 1, last.y() - first.y() + 1};
  }
};
ComparedCells compared_cells(const simulation::FloorPlanTruth& plan, const fusion::FloorGrid& grid,
                             const fusion::Storeys& storeys,
                             const geometry::RigidTransform& truth_from_gravity) {
  const simulation::FreeSpaceTruth& truth = plan.free_space;
  ComparedCells cells{{0, 0}, {columns_of(truth) - 1, rows_of(truth) - 1}};
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      if (grid.at(column, row) != fusion::FloorCell::kFree) continue;
      const Vector2d middle = grid.cell_middle_m(column, row);
      const Vector2d place = plan.plan_from_world(
          truth_from_gravity * storeys.gravity_from_plan({middle.x(), middle.y(), 0}));
      const Eigen::Array2i cell =
          ((place - truth.origin_m) / truth.cell_m).array().floor().cast<int>();
      cells.first = cells.first.min(cell);
      cells.last = cells.last.max(cell);
    }
  }
  return cells;
}

evaluation::StandingRoom true_cells(const simulation::FreeSpaceTruth& truth,
                                    const ComparedCells& compared) {
  evaluation::StandingRoom free = compared.nowhere();
  for (int row = 0; row < rows_of(truth); ++row) {
    const std::string& cells = truth.rows[static_cast<std::size_t>(row)];
    for (int column = 0; column < columns_of(truth); ++column) {
      const auto place = static_cast<std::size_t>(column);
      free.at(column - compared.first.x(), row - compared.first.y()) =
          place < cells.size() && cells[place] == '.' ? 1 : 0;
    }
  }
  return free;
}

// What the map says of the middles of these cells.
evaluation::StandingRoom found_cells(const simulation::FloorPlanTruth& plan,
                                     const fusion::FloorGrid& grid, const fusion::Storeys& storeys,
                                     const geometry::RigidTransform& gravity_from_truth,
                                     const ComparedCells& compared) {
  const simulation::FreeSpaceTruth& truth = plan.free_space;
  evaluation::StandingRoom free = compared.nowhere();
  for (int row = 0; row < free.height(); ++row) {
    for (int column = 0; column < free.width(); ++column) {
      const Vector2d middle =
          truth.origin_m + truth.cell_m * Vector2d(column + compared.first.x() + 0.5,
                                                   row + compared.first.y() + 0.5);
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
  ROOMWISE_TRY(pipeline::GravityAlignedMap map,
               pipeline::build_gravity_aligned_map(home, {.keeps_colors = false}, run));
  ROOMWISE_TRY(const fusion::FloorGrid grid, pipeline::floor_grid_of(map, {}, run));
  const geometry::RigidTransform gravity_from_truth =
      map.frame.gravity_from_world * truth_from_world.inverse();

  const ComparedCells compared =
      compared_cells(plan, grid, map.frame.storeys, gravity_from_truth.inverse());
  const evaluation::StandingRoom is_true = true_cells(truth, compared);
  const evaluation::StandingRoom is_found =
      found_cells(plan, grid, map.frame.storeys, gravity_from_truth, compared);
  FloorEvaluation result;
  ROOMWISE_TRY(result.error, evaluation::floor_error(is_true, is_found, truth.cell_m));
  const Vector2d middle =
      truth.origin_m + truth.cell_m / 2 * Vector2d(columns_of(truth), rows_of(truth));
  result.floor_above_truth_m = -(gravity_from_truth * Vector3d(middle.x(), middle.y(), 0)).z();
  const Vector3d up = gravity_from_truth.rotation * Vector3d::UnitZ();
  result.tilt_rad = std::atan2(up.head<2>().norm(), up.z());
  return result;
}

}  // namespace roomwise::trials
