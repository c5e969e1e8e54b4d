#include "roomwise/pipeline/mapping/dense_map.h"

#include <map>

#include "roomwise/pipeline/stored/keyframe_images.h"

namespace roomwise::pipeline {

Expected<void> DenseMap::follow(const home::Home& home, std::span<const home::Keyframe> keyframes,
                                RunContext& run) {
  fusion::FramePoses poses;
  for (const home::Keyframe& keyframe : keyframes) {
    poses[keyframe.id] = keyframe.pose.world_from_keyframe;
  }
  std::map<fusion::FrameId, fusion::Reintegration> steps;
  for (const fusion::Reintegration& step : fusion_.reintegrations_for(poses))
    steps[step.frame] = step;
  ROOMWISE_TRY(auto moving, home.keyframes());
  std::erase_if(moving,
                [&](const home::Keyframe& keyframe) { return !steps.contains(keyframe.id); });
  ROOMWISE_TRY(const auto cameras, recording_cameras(home));
  std::map<home::RecordingId, fusion::FrameSurfaceMaker> makers;
  for (const auto& [id, camera] : cameras) {
    makers.emplace(id, fusion::FrameSurfaceMaker(camera, surface_));
  }
  return for_each_keyframe(
      home, moving, "fusing the map", run,
      [&](const home::Keyframe& keyframe, const DecodedImages& images) {
        const auto timing = run.clock.measure("surfaces");
        return makers.at(keyframe.recording).make(images.color, images.depth);
      },
      [&](const home::Keyframe& keyframe, const fusion::FrameSurface& surface) {
        return fusion_.apply(steps.at(keyframe.id), surface, run.pool);
      });
}

Expected<DenseMap> build_dense_map(const home::Home& home,
                                   std::span<const home::Keyframe> keyframes,
                                   const fusion::TsdfOptions& field, RunContext& run) {
  fusion::MapFusionOptions options;
  options.field = field;
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  DenseMap map(options);
  ROOMWISE_RETURN_IF_ERROR(map.follow(home, keyframes, run));
  return map;
}

}  // namespace roomwise::pipeline
