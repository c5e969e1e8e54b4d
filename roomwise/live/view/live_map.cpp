#include "roomwise/live/view/live_map.h"

#include "roomwise/pipeline/mapping/home_floor.h"
#include "roomwise/pipeline/rooms/room_outline.h"

namespace roomwise::live {

Expected<geometry::PointCloud> thinned(const fusion::PiecewiseMesh& mesh, std::size_t most) {
  for (double voxel_m = 0.03;; voxel_m *= 1.25) {
    geometry::VoxelGrid grid(voxel_m);
    ROOMWISE_RETURN_IF_ERROR(mesh.for_each([&](const fusion::MeshPiece& piece) {
      for (std::size_t i = 0; i < piece.own && grid.size() <= most; ++i)
        grid.add(piece.mesh.vertices[i].cast<double>(), piece.mesh.colors[i]);
    }));
    if (grid.size() <= most) return grid.cloud();
  }
}

Expected<std::shared_ptr<const LiveMap>> make_live_map(const home::Home& home,
                                                       pipeline::RunContext& run) {
  ROOMWISE_TRY(auto localizer, pipeline::HomeLocalizer::create(home, {}, run));
  ROOMWISE_TRY(pipeline::HomeFloor floor, pipeline::find_home_floor(home, run));
  const double right_rad =
      floor.grid ? pipeline::drawing_direction_rad(*floor.grid, floor.frame.storeys) : 0;
  return std::make_shared<const LiveMap>(
      LiveMap{.frame = floor.frame,
              .floor = std::move(floor.grid),
              .right_rad = right_rad,
              .clouds = nullptr,
              .localizer = std::make_shared<const pipeline::HomeLocalizer>(std::move(localizer))});
}

Expected<std::shared_ptr<const LiveMap>> with_clouds(const LiveMap& map, const home::Home& home,
                                                     pipeline::RunContext& run) {
  ROOMWISE_TRY(const pipeline::GravityAlignedMap fused,
               pipeline::build_gravity_aligned_map(home, {}, run));
  const auto surface_gravity = fusion::transformed(map.frame.gravity_from_world, fused.mesh_world);
  ROOMWISE_TRY(auto fine, thinned(surface_gravity, MapClouds::kMaxFine));
  ROOMWISE_TRY(auto coarse, thinned(surface_gravity, MapClouds::kMaxCoarse));
  auto whole = std::make_shared<LiveMap>(map);
  whole->clouds = std::make_shared<const MapClouds>(MapClouds{std::move(fine), std::move(coarse)});
  return whole;
}

}  // namespace roomwise::live
