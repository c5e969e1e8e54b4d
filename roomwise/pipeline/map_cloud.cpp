#include "roomwise/pipeline/map_cloud.h"

#include <algorithm>
#include <future>
#include <memory>

#include "roomwise/image/codec.h"
#include "roomwise/mapping/frame_cloud.h"

namespace roomwise::pipeline {
namespace {

struct DecodedKeyframe {
  geometry::PointCloud cloud;
  image::DepthImage depth;
};

Expected<DecodedKeyframe> decode(const home::KeyframeImages& images,
                                 const mapping::FrameCloudMaker& maker) {
  ROOMWISE_TRY(const image::ColorImage color, image::decode_color(images.color));
  ROOMWISE_TRY(image::DepthImage depth, image::decode_depth(images.depth));
  geometry::PointCloud cloud = maker.make(color, depth);
  return DecodedKeyframe{std::move(cloud), std::move(depth)};
}

}  // namespace

Expected<MapCloud> build_map_cloud(const home::Home& home, double voxel_size_m, RunContext& run) {
  if (!(voxel_size_m > 0)) return fail("the voxel size {} m must be positive", voxel_size_m);
  ROOMWISE_TRY(const auto recordings, home.recordings());
  ROOMWISE_TRY(auto keyframes, home.keyframes());
  std::erase_if(keyframes, [](const home::Keyframe& keyframe) { return keyframe.pose.piece != 0; });
  std::map<home::RecordingId, std::pair<geometry::PinholeCamera, mapping::FrameCloudMaker>> makers;
  for (const home::StoredRecording& stored : recordings) {
    const geometry::PinholeCamera& camera = stored.recording.camera;
    makers.emplace(stored.id, std::pair(camera, mapping::FrameCloudMaker(camera)));
  }

  geometry::VoxelGrid grid(voxel_size_m);
  mapping::UpDirectionEstimator up;
  run.progress.begin("building the cloud", keyframes.size());
  // Decoding is the threads' work; the points are added in the order of the key-frames, in blocks.
  const std::size_t block = 4 * run.pool.size();
  for (std::size_t first = 0; first < keyframes.size(); first += block) {
    if (run.progress.interrupted()) return fail("interrupted while building the cloud");
    const std::size_t count = std::min(block, keyframes.size() - first);
    std::vector<home::KeyframeImages> images;
    for (std::size_t i = 0; i < count; ++i) {
      ROOMWISE_TRY(home::KeyframeImages one, home.images(keyframes[first + i].id));
      images.push_back(std::move(one));
    }
    std::vector<Expected<DecodedKeyframe>> decoded(count);
    run.pool.parallel_for(count, [&](std::size_t i) {
      decoded[i] = decode(images[i], makers.at(keyframes[first + i].recording).second);
    });
    for (std::size_t i = 0; i < count; ++i) {
      const home::Keyframe& keyframe = keyframes[first + i];
      if (!decoded[i]) {
        return Unexpected(std::move(decoded[i])
                              .error()
                              .in(fmt::format("{}: key-frame {}", home.file(), keyframe.id)));
      }
      const geometry::RigidTransform& world_from_camera = keyframe.pose.world_from_keyframe;
      grid.add(world_from_camera, decoded[i]->cloud);
      up.add(world_from_camera, decoded[i]->depth, makers.at(keyframe.recording).first);
    }
    run.progress.advance(first + count, "");
  }
  run.progress.end();
  return MapCloud{grid.cloud(), up.estimate()};
}

}  // namespace roomwise::pipeline
