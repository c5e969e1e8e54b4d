#include "roomwise/pipeline/stored_keyframes.h"

#include <utility>

#include "roomwise/pipeline/keyframe_images.h"
#include "roomwise/pipeline/measured_frame_reader.h"

namespace roomwise::pipeline {

Expected<void> measure_each_keyframe(const home::Home& home,
                                     std::span<const home::Keyframe> keyframes,
                                     const geometry::PinholeCamera& camera,
                                     const features::FeatureExtractor& extractor,
                                     const MapSettings& settings, RunContext& run,
                                     const TakeKeyframe& take) {
  const auto measure = [&](const home::Keyframe&, const DecodedImages& images) {
    return measure_frame(images.color, images.depth, camera, extractor, settings);
  };
  const auto hand_over = [&](const home::Keyframe& keyframe,
                             motion::FrameMeasurements measurements) {
    return take(
        {keyframe.id, keyframe.frame_index, keyframe.timestamp_ns, std::move(measurements)});
  };
  return for_each_keyframe(home, keyframes, "loading the map", run, measure, hand_over);
}

Expected<std::vector<mapping::Keyframe>> measure_keyframes(
    const home::Home& home, std::span<const home::Keyframe> keyframes,
    const geometry::PinholeCamera& camera, const features::FeatureExtractor& extractor,
    const MapSettings& settings, RunContext& run) {
  std::vector<mapping::Keyframe> measured;
  const auto keep = [&](mapping::Keyframe keyframe) -> Expected<void> {
    measured.push_back(std::move(keyframe));
    return {};
  };
  ROOMWISE_CHECK_OK(measure_each_keyframe(home, keyframes, camera, extractor, settings, run, keep));
  return measured;
}

}  // namespace roomwise::pipeline
