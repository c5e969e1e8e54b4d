#include "roomwise/pipeline/stored_keyframes.h"

#include <utility>

#include "roomwise/pipeline/keyframe_images.h"
#include "roomwise/pipeline/measured_frame_reader.h"

namespace roomwise::pipeline {

Expected<std::vector<mapping::Keyframe>> measure_keyframes(
    const home::Home& home, std::span<const home::Keyframe> keyframes,
    const geometry::PinholeCamera& camera, const features::FeatureExtractor& extractor,
    const MapSettings& settings, RunContext& run) {
  std::vector<mapping::Keyframe> measured;
  const auto measure = [&](const home::Keyframe&, const DecodedImages& images) {
    return measure_frame(images.color, images.depth, camera, extractor, settings);
  };
  const auto keep = [&](const home::Keyframe& keyframe,
                        motion::FrameMeasurements measurements) -> Expected<void> {
    measured.push_back(
        {keyframe.id, keyframe.frame_index, keyframe.timestamp_ns, std::move(measurements)});
    return {};
  };
  ROOMWISE_CHECK_OK(for_each_keyframe(home, keyframes, "loading the map", run, measure, keep));
  return measured;
}

}  // namespace roomwise::pipeline
