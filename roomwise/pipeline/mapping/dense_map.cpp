#include "roomwise/pipeline/mapping/dense_map.h"

#include <unistd.h>

#include <filesystem>
#include <map>
#include <utility>

#include "roomwise/fusion/frame_fusion.h"
#include "roomwise/pipeline/stored/keyframe_images.h"

namespace roomwise::pipeline {
namespace {

// Of a depth image between pictures: above those of key-frames, which have their own ids.
fusion::FrameId frame_id_of(const home::DepthView& view) {
  return (fusion::FrameId{1} << 48U) + view.id;
}

fusion::FramePoses poses_of(std::span<const home::Keyframe> keyframes,
                            std::span<const home::DepthView> views) {
  fusion::FramePoses poses;
  for (const home::Keyframe& keyframe : keyframes) {
    poses[keyframe.id] = keyframe.pose.world_from_keyframe;
  }
  for (const home::DepthView& view : views) {
    if (poses.size() >= fusion::kMaxFrames) break;  // key-frames first
    const auto keyframe = poses.find(view.keyframe);
    if (keyframe != poses.end()) {
      poses[frame_id_of(view)] = keyframe->second * view.keyframe_from_view;
    }
  }
  return poses;
}

}  // namespace

Expected<void> DenseMap::follow(const home::Home& home, std::span<const home::Keyframe> keyframes,
                                RunContext& run) {
  ROOMWISE_TRY(auto views, home.depth_views());
  std::map<fusion::FrameId, fusion::Reintegration> steps;
  for (const auto& step : fusion_.reintegrations_for(poses_of(keyframes, views))) {
    steps[step.frame] = step;
  }
  ROOMWISE_TRY(const auto cameras, recording_cameras(home));
  std::map<home::RecordingId, fusion::FrameSurfaceMaker> makers;
  for (const auto& [id, camera] : cameras) {
    makers.emplace(id, fusion::FrameSurfaceMaker(camera, surface_));
  }
  ROOMWISE_TRY(auto moving, home.keyframes());
  std::erase_if(moving,
                [&](const home::Keyframe& keyframe) { return !steps.contains(keyframe.id); });
  std::erase_if(views,
                [&](const home::DepthView& view) { return !steps.contains(frame_id_of(view)); });
  ROOMWISE_RETURN_IF_ERROR(for_each_keyframe(
      home, moving, "fusing the map", run,
      [&](const home::Keyframe& keyframe, const DecodedImages& images) {
        const auto timing = run.clock.measure("surfaces");
        return makers.at(keyframe.recording).make(images.color, images.depth);
      },
      [&](const home::Keyframe& keyframe, const fusion::FrameSurface& surface) {
        return fusion_.apply(steps.at(keyframe.id), surface, run.pool);
      }));
  return for_each_depth_view(
      home, views, "fusing depth between pictures", run,
      [&](const home::DepthView& view, const image::DepthImage& depth) {
        const auto timing = run.clock.measure("surfaces");
        return makers.at(view.recording).make(depth);
      },
      [&](const home::DepthView& view, const fusion::FrameSurface& surface) {
        return fusion_.apply(steps.at(frame_id_of(view)), surface, run.pool);
      });
}

WorkingSet dense_working_set(const home::Home& home, const RunContext& run) {
  std::filesystem::path folder = std::filesystem::absolute(home.file()).parent_path();
  std::error_code none;  // then all stays in memory
  if (access(folder.c_str(), W_OK) != 0) folder = std::filesystem::temp_directory_path(none);
  return {run.working_set_bytes, std::move(folder)};
}

Expected<DenseMap> build_dense_map(const home::Home& home,
                                   std::span<const home::Keyframe> keyframes,
                                   const fusion::TsdfOptions& field, RunContext& run) {
  fusion::MapFusionOptions options;
  options.field = field;
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  DenseMap map(options, dense_working_set(home, run));
  ROOMWISE_RETURN_IF_ERROR(map.follow(home, keyframes, run));
  return map;
}

}  // namespace roomwise::pipeline
