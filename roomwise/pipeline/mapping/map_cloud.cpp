#include "roomwise/pipeline/mapping/map_cloud.h"

#include <map>

#include "roomwise/mapping/cloud/frame_cloud.h"
#include "roomwise/pipeline/stored/keyframe_images.h"
#include "roomwise/pipeline/stored/stored_map.h"

namespace roomwise::pipeline {

Expected<MapCloud> build_map_cloud(const home::Home& home, double voxel_size_m, RunContext& run) {
  ROOMWISE_TRY(const auto keyframes, map_keyframes(home));
  return build_map_cloud(home, keyframes, voxel_size_m, run);
}

Expected<MapCloud> build_map_cloud(const home::Home& home,
                                   std::span<const home::Keyframe> keyframes, double voxel_size_m,
                                   RunContext& run) {
  if (!(voxel_size_m > 0)) return fail("the voxel size {} m must be positive", voxel_size_m);
  ROOMWISE_TRY(const auto cameras, recording_cameras(home));
  std::map<home::RecordingId, mapping::FrameCloudMaker> makers;
  for (const auto& [id, camera] : cameras) makers.emplace(id, mapping::FrameCloudMaker(camera));

  struct Seen {
    geometry::PointCloud cloud;
    image::DepthImage depth;
  };
  geometry::VoxelGrid grid(voxel_size_m);
  mapping::UpDirectionEstimator up;
  ROOMWISE_TRY(const auto gravity, stored_gravity(home, keyframes));
  for (const auto& [id, up_world] : gravity) up.add_gravity(up_world);
  ROOMWISE_RETURN_IF_ERROR(for_each_keyframe(
      home, keyframes, "building the cloud", run,
      [&](const home::Keyframe& keyframe, const DecodedImages& images) {
        return Seen{makers.at(keyframe.recording).make(images.color, images.depth), images.depth};
      },
      [&](const home::Keyframe& keyframe, const Seen& seen) -> Expected<void> {
        const geometry::RigidTransform& world_from_camera = keyframe.pose.world_from_keyframe;
        grid.add(world_from_camera, seen.cloud);
        up.add(world_from_camera, seen.depth, cameras.at(keyframe.recording));
        return {};
      }));
  return MapCloud{grid.cloud(), up.estimate()};
}

}  // namespace roomwise::pipeline
