#include "roomwise/pipeline/mapping/gravity_aligned_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "roomwise/pipeline/stored/keyframe_images.h"
#include "roomwise/pipeline/stored/stored_map.h"

namespace roomwise::pipeline {
namespace {

// Where the camera was at each frame of each walk, on the map.
Expected<std::vector<fusion::CameraPath>> walked_paths(const home::Home& home,
                                                       const fusion::GravityAlignedFrame& frame) {
  ROOMWISE_TRY(const auto frames, walked_frames(home));
  std::map<home::RecordingId, fusion::CameraPath> by_walk;
  for (const WalkedFrame& one : frames)
    by_walk[one.recording].push_back(frame.gravity_from_world * one.at_world);
  std::vector<fusion::CameraPath> paths;
  for (auto& [walk, path] : by_walk) paths.push_back(std::move(path));
  return paths;
}

// The storeys with their places on the plan; one where the walks show no more.
Expected<fusion::Storeys> storeys_of(const fusion::PiecewiseMesh& mesh_gravity,
                                     fusion::StoreysFound found) {
  if (found.floors_m.size() < 2) return fusion::Storeys();
  constexpr double kSame_m = 0.1;  // the floor of the frame is one of them
  if (std::abs(found.floors_m.front()) < kSame_m) found.floors_m.front() = 0;
  float from_x = std::numeric_limits<float>::infinity(), to_x = -from_x;
  ROOMWISE_RETURN_IF_ERROR(mesh_gravity.for_each([&](const fusion::MeshPiece& piece) {
    for (const Eigen::Vector3f& vertex : piece.own_vertices()) {
      from_x = std::min(from_x, vertex.x());
      to_x = std::max(to_x, vertex.x());
    }
  }));
  // Whole metres, which all usual cells divide, and two of them between storeys.
  const double apart_m = std::ceil(static_cast<double>(to_x - from_x)) + 2;
  std::vector<fusion::Storey> storeys;
  for (std::size_t i = 0; i < found.floors_m.size(); ++i) {
    fusion::Storey& storey = storeys.emplace_back();
    storey.floor_m = found.floors_m[i];
    storey.plan_from_gravity.x() = apart_m * static_cast<double>(i);
    if (i > 0)
      storey.plan_from_x_m = static_cast<double>(from_x) + storey.plan_from_gravity.x() - 1;
  }
  for (fusion::Staircase& stairs : found.stairs) {
    stairs.below_plan += storeys[stairs.lower].plan_from_gravity;
    stairs.above_plan += storeys[stairs.lower + 1].plan_from_gravity;
  }
  return fusion::Storeys(std::move(storeys), std::move(found.stairs));
}

// Each storey's grid where it is drawn on the plan.
fusion::FloorGrid on_plan(const std::vector<fusion::FloorGrid>& grids,
                          const fusion::Storeys& storeys) {
  const fusion::FloorGrid& first = grids.front();
  const fusion::FloorGrid& last = grids.back();
  const double cell_m = first.cell_m();
  const double width_m = last.origin_m().x() + last.columns() * cell_m +
                         storeys.all().back().plan_from_gravity.x() - first.origin_m().x();
  const int rows = std::ranges::max(grids, {}, &fusion::FloorGrid::rows).rows();
  image::Image<fusion::FloorCell> cells(static_cast<int>(std::ceil(width_m / cell_m)), rows,
                                        fusion::FloorCell::kUnknown);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < cells.width(); ++column) {
      const Eigen::Vector2d middle =
          first.origin_m() + cell_m * Eigen::Vector2d(column + 0.5, row + 0.5);
      const std::size_t storey = storeys.at_plan(middle);
      cells.at(column, row) =
          grids[storey].at(Eigen::Vector2d(middle - storeys.all()[storey].plan_from_gravity));
    }
  }
  return {first.origin_m(), cell_m, std::move(cells)};
}

}  // namespace

Expected<GravityAlignedMap> build_gravity_aligned_map(const home::Home& home,
                                                      const fusion::TsdfOptions& field,
                                                      RunContext& run) {
  ROOMWISE_TRY(const auto keyframes, map_keyframes(home));
  if (keyframes.empty()) {
    return fail("{}: the home has no map yet; make one with roomwise map", home.file());
  }
  ROOMWISE_TRY(DenseMap dense, build_dense_map(home, keyframes, field, run));
  ROOMWISE_TRY(fusion::PiecewiseMesh mesh,
               extract_mesh(dense.field(), fusion::MeshOptions{}, run.pool));
  ROOMWISE_RETURN_IF_ERROR(run.progress.check("the surface was extracted"));
  std::vector<geometry::RigidTransform> cameras;
  for (const home::Keyframe& keyframe : keyframes) {
    cameras.push_back(keyframe.pose.world_from_keyframe);
  }
  ROOMWISE_TRY(const auto felt, stored_gravity(home, keyframes));
  std::vector<Eigen::Vector3d> gravity;
  for (const auto& [id, up_world] : felt) gravity.push_back(up_world);
  ROOMWISE_TRY(fusion::GravityAlignedFrame frame,
               fusion::find_gravity_aligned_frame(mesh, cameras, gravity));
  ROOMWISE_RETURN_IF_ERROR(run.progress.check("the floor was found"));
  if (frame.has_floor) {
    ROOMWISE_TRY(const auto paths, walked_paths(home, frame));
    const auto mesh_gravity = fusion::transformed(frame.gravity_from_world, mesh);
    ROOMWISE_TRY(fusion::StoreysFound found, fusion::find_storeys(mesh_gravity, paths));
    frame.gravity_from_world.translation.z() -= fusion::only_level_m(found);
    ROOMWISE_TRY(frame.storeys, storeys_of(mesh_gravity, std::move(found)));
  }
  return GravityAlignedMap{std::move(dense), std::move(mesh), frame};
}

Expected<void> validate_cell(double cell_m, double voxel_size_m) {
  // The field knows distances up to the truncation; a free cell's middle is half a cell from all.
  const double min_m = 2 * voxel_size_m;
  const double max_m = 2 * fusion::TsdfOptions{}.truncation_voxels * voxel_size_m;
  if (cell_m >= min_m && cell_m <= max_m) return {};
  return fail(
      "cells of {:g} m do not go with voxels of {:g} m; give cells of {:g} to {:g} m, or other "
      "voxels",
      cell_m, voxel_size_m, min_m, max_m);
}

Expected<std::vector<fusion::OccupancyCell>> occupancy_of(GravityAlignedMap& map, double cell_m,
                                                          RunContext& run) {
  ROOMWISE_RETURN_IF_ERROR(validate_cell(cell_m, map.dense.field().voxel_size_m()));
  return fusion::occupancy_cells(map.dense.field(), map.mesh_world, map.frame.gravity_from_world,
                                 cell_m, run.pool);
}

Expected<std::vector<fusion::FloorGrid>> floor_grids_of(GravityAlignedMap& map,
                                                        const fusion::FloorGridOptions& options,
                                                        RunContext& run) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  if (!map.frame.has_floor) {
    return fail("the map shows no floor; walk with the camera tilted down a little");
  }
  ROOMWISE_RETURN_IF_ERROR(validate_cell(options.cell_m, map.dense.field().voxel_size_m()));
  std::vector<fusion::FloorGrid> grids;
  for (std::size_t i = 0; i < map.frame.storeys.count(); ++i) {
    geometry::RigidTransform storey_from_world = map.frame.gravity_from_world;
    storey_from_world.translation.z() -= map.frame.storeys.floor_m(i);
    const auto visit_free_cells = [&](const auto& visit) {
      return fusion::visit_free_cells(map.dense.field(), storey_from_world, options.cell_m,
                                      run.pool, visit);
    };
    ROOMWISE_TRY(fusion::FloorGrid grid, fusion::make_floor_grid(map.mesh_world, storey_from_world,
                                                                 visit_free_cells, options));
    ROOMWISE_RETURN_IF_ERROR(run.progress.check("a floor was drawn"));
    grids.push_back(std::move(grid));
  }
  return grids;
}

Expected<fusion::FloorGrid> floor_grid_of(GravityAlignedMap& map,
                                          const fusion::FloorGridOptions& options,
                                          RunContext& run) {
  ROOMWISE_TRY(auto grids, floor_grids_of(map, options, run));
  if (grids.size() == 1) return std::move(grids.front());
  return on_plan(grids, map.frame.storeys);
}

}  // namespace roomwise::pipeline
