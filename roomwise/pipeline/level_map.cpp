#include "roomwise/pipeline/level_map.h"

#include "roomwise/pipeline/keyframe_images.h"

namespace roomwise::pipeline {

Expected<LevelMap> build_level_map(const home::Home& home, double voxel_size_m, RunContext& run) {
  ROOMWISE_TRY(const auto keyframes, map_keyframes(home));
  ROOMWISE_TRY(DenseMap dense, build_dense_map(home, keyframes, voxel_size_m, run));
  fusion::TriangleMesh mesh = extract_mesh(dense.field(), fusion::MeshOptions{}, run.pool);
  std::vector<geometry::RigidTransform> cameras;
  for (const home::Keyframe& keyframe : keyframes) {
    cameras.push_back(keyframe.pose.world_from_keyframe);
  }
  const fusion::LevelFrame frame = fusion::find_level_frame(mesh, cameras);
  return LevelMap{std::move(dense), std::move(mesh), frame};
}

std::vector<fusion::OccupancyCell> occupancy_of(const LevelMap& map, double cell_m,
                                                RunContext& run) {
  return fusion::occupancy_cells(map.dense.field(), map.mesh_world, map.frame.level_from_world,
                                 cell_m, run.pool);
}

Expected<fusion::FloorGrid> floor_grid_of(const LevelMap& map,
                                          const fusion::FloorGridOptions& options,
                                          RunContext& run) {
  ROOMWISE_CHECK_OK(options.validate());
  if (!map.frame.has_floor) {
    return fail("the map shows no floor; walk with the camera tilted down a little");
  }
  return fusion::make_floor_grid(fusion::transformed(map.frame.level_from_world, map.mesh_world),
                                 occupancy_of(map, options.cell_m, run), options);
}

}  // namespace roomwise::pipeline
