#include "roomwise/live/live_map.h"

#include "roomwise/pipeline/mapping/gravity_aligned_map.h"

namespace roomwise::live {

geometry::PointCloud thinned(const fusion::TriangleMesh& mesh, std::size_t most) {
  for (double voxel_m = 0.03;; voxel_m *= 1.25) {
    geometry::VoxelGrid grid(voxel_m);
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      grid.add(mesh.vertices[i].cast<double>(), mesh.colors[i]);
    }
    if (grid.size() <= most) return grid.cloud();
  }
}

Expected<std::shared_ptr<const LiveMap>> make_live_map(const home::Home& home,
                                                       pipeline::RunContext& run) {
  ROOMWISE_TRY(auto localizer, pipeline::HomeLocalizer::create(home, {}, run));
  ROOMWISE_TRY(const pipeline::GravityAlignedMap level,
               pipeline::build_gravity_aligned_map(home, fusion::TsdfOptions{}.voxel_size_m, run));
  std::optional<fusion::FloorGrid> floor;
  if (level.frame.has_floor) {
    ROOMWISE_TRY(floor, pipeline::floor_grid_of(level, {}, run));
  }
  const auto surface_gravity =
      fusion::transformed(level.frame.gravity_from_world, level.mesh_world);
  return std::make_shared<const LiveMap>(
      LiveMap{.frame = level.frame,
              .floor = std::move(floor),
              .cloud_gravity = thinned(surface_gravity, LiveMap::kMaxPoints),
              .coarse_cloud_gravity = thinned(surface_gravity, LiveMap::kMaxCoarsePoints),
              .localizer = std::make_unique<const pipeline::HomeLocalizer>(std::move(localizer))});
}

}  // namespace roomwise::live
