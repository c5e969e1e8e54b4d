#include "roomwise/pipeline/mapping/gravity_aligned_map.h"

#include "roomwise/pipeline/stored/keyframe_images.h"
#include "roomwise/pipeline/stored/stored_map.h"

namespace roomwise::pipeline {

Expected<GravityAlignedMap> build_gravity_aligned_map(const home::Home& home, double voxel_size_m,
                                                      RunContext& run) {
  ROOMWISE_TRY(const auto keyframes, map_keyframes(home));
  if (keyframes.empty()) {
    return fail("{}: the home has no map yet; make one with roomwise map", home.file());
  }
  ROOMWISE_TRY(DenseMap dense, build_dense_map(home, keyframes, voxel_size_m, run));
  fusion::TriangleMesh mesh = extract_mesh(dense.field(), fusion::MeshOptions{}, run.pool);
  ROOMWISE_CHECK_OK(run.progress.check("the surface was extracted"));
  std::vector<geometry::RigidTransform> cameras;
  for (const home::Keyframe& keyframe : keyframes) {
    cameras.push_back(keyframe.pose.world_from_keyframe);
  }
  ROOMWISE_TRY(const auto felt, stored_gravity(home, keyframes));
  std::vector<Eigen::Vector3d> gravity;
  for (const auto& [id, up_world] : felt) gravity.push_back(up_world);
  const fusion::GravityAlignedFrame frame =
      fusion::find_gravity_aligned_frame(mesh, cameras, gravity);
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

Expected<std::vector<fusion::OccupancyCell>> occupancy_of(const GravityAlignedMap& map,
                                                          double cell_m, RunContext& run) {
  ROOMWISE_CHECK_OK(validate_cell(cell_m, map.dense.field().voxel_size_m()));
  return fusion::occupancy_cells(map.dense.field(), map.mesh_world, map.frame.gravity_from_world,
                                 cell_m, run.pool);
}

Expected<fusion::FloorGrid> floor_grid_of(const GravityAlignedMap& map,
                                          const fusion::FloorGridOptions& options,
                                          RunContext& run) {
  ROOMWISE_CHECK_OK(options.validate());
  if (!map.frame.has_floor) {
    return fail("the map shows no floor; walk with the camera tilted down a little");
  }
  ROOMWISE_TRY(const auto cells, occupancy_of(map, options.cell_m, run));
  return fusion::make_floor_grid(fusion::transformed(map.frame.gravity_from_world, map.mesh_world),
                                 cells, options);
}

}  // namespace roomwise::pipeline
