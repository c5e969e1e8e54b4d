#include "roomwise/pipeline/stored/stored_keyframes.h"

#include <memory>
#include <utility>

#include "roomwise/image/resample.h"
#include "roomwise/pipeline/stored/keyframe_images.h"
#include "roomwise/pipeline/stored/measured_frame_reader.h"

namespace roomwise::pipeline {

Expected<void> measure_each_keyframe(const home::Home& home,
                                     std::span<const home::Keyframe> keyframes,
                                     const features::FeatureExtractor& extractor,
                                     const MapSettings& settings, RunContext& run,
                                     const TakeKeyframe& take) {
  ROOMWISE_TRY(const auto cameras, recording_cameras(home));
  const auto measure = [&](const home::Keyframe& keyframe, const DecodedImages& images) {
    return measure_frame(images.color, images.depth, cameras.at(keyframe.recording), extractor,
                         settings);
  };
  const auto hand_over = [&](const home::Keyframe& keyframe,
                             motion::FrameMeasurements measurements) {
    return take({keyframe, std::move(measurements)});
  };
  const auto hand_over_blank = [&](const home::Keyframe& keyframe) {
    return hand_over(keyframe, measure(keyframe, blank(cameras.at(keyframe.recording))));
  };
  return for_each_keyframe(home, keyframes, "loading the map", run, measure, hand_over,
                           hand_over_blank);
}

Expected<std::vector<mapping::Keyframe>> measure_keyframes(
    const home::Home& home, std::span<const home::Keyframe> keyframes,
    const features::FeatureExtractor& extractor, const MapSettings& settings, RunContext& run) {
  std::vector<mapping::Keyframe> measured;
  const auto keep = [&](mapping::Keyframe keyframe) -> Expected<void> {
    measured.push_back(std::move(keyframe));
    return {};
  };
  ROOMWISE_RETURN_IF_ERROR(measure_each_keyframe(home, keyframes, extractor, settings, run, keep));
  return measured;
}

Expected<mapping::FindFeatures> stored_keyframe_features(const home::Home& home,
                                                         const MapSettings& settings,
                                                         RunContext& run) {
  ROOMWISE_TRY(auto stored, home.keyframes());
  ROOMWISE_TRY(auto cameras, recording_cameras(home));
  // Shared: what std::function holds must be copyable.
  const std::shared_ptr<const features::FeatureExtractor> extractor =
      features::make_extractor(settings.features, settings.max_keypoints);
  return [&home, &settings, &run, stored = std::move(stored), cameras = std::move(cameras),
          extractor](std::span<const home::KeyframeId> ids)
             -> Expected<std::vector<mapping::KeyframeFeatures>> {
    std::vector<home::Keyframe> keyframes;
    for (const home::KeyframeId id : ids) keyframes.push_back(stored[id]);
    const auto measure = [&](const home::Keyframe& keyframe, const DecodedImages& images) {
      const geometry::PinholeCamera& camera = cameras.at(keyframe.recording);
      // Views are for what tells which way is up.
      if (settings.refinement.uses_gravity) {
        return mapping::keyframe_features(
            measure_frame(images.color, images.depth, camera, *extractor, settings), camera,
            settings.refinement.landmarks);
      }
      return mapping::keyframe_features(
          motion::measure_features(extractor->extract(image::to_gray(images.color)), images.depth,
                                   camera, settings.depth),
          camera, settings.refinement.landmarks);
    };
    std::vector<mapping::KeyframeFeatures> found;
    const auto keep = [&](const home::Keyframe&,
                          mapping::KeyframeFeatures features) -> Expected<void> {
      found.push_back(std::move(features));
      return {};
    };
    const auto keep_blank = [&](const home::Keyframe& keyframe) {
      return keep(keyframe, measure(keyframe, blank(cameras.at(keyframe.recording))));
    };
    ROOMWISE_RETURN_IF_ERROR(for_each_keyframe(home, keyframes, "finding features again", run,
                                               measure, keep, keep_blank));
    return found;
  };
}

}  // namespace roomwise::pipeline
