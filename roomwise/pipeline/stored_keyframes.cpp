#include "roomwise/pipeline/stored_keyframes.h"

#include <algorithm>
#include <utility>

#include "roomwise/image/codec.h"
#include "roomwise/pipeline/measured_frame_reader.h"

namespace roomwise::pipeline {
namespace {

Expected<motion::FrameMeasurements> measure_stored(const home::KeyframeImages& images,
                                                   const geometry::PinholeCamera& camera,
                                                   const features::FeatureExtractor& extractor,
                                                   const MapSettings& settings) {
  ROOMWISE_TRY(const image::ColorImage color, image::decode_color(images.color));
  ROOMWISE_TRY(const image::DepthImage depth, image::decode_depth(images.depth));
  return measure_frame(color, depth, camera, extractor, settings);
}

}  // namespace

Expected<std::vector<mapping::Keyframe>> measure_keyframes(
    const home::Home& home, std::span<const home::Keyframe> keyframes,
    const geometry::PinholeCamera& camera, const features::FeatureExtractor& extractor,
    const MapSettings& settings, RunContext& run) {
  std::vector<mapping::Keyframe> result;
  run.progress.begin("loading the map", keyframes.size());
  // In blocks: reading is the database's, finding features the threads' work.
  const std::size_t block = 4 * run.pool.size();
  for (std::size_t first = 0; first < keyframes.size(); first += block) {
    const std::size_t end = std::min(keyframes.size(), first + block);
    std::vector<home::KeyframeImages> images;
    for (std::size_t i = first; i < end; ++i) {
      ROOMWISE_TRY(home::KeyframeImages one, home.images(keyframes[i].id));
      images.push_back(std::move(one));
    }
    std::vector<Expected<motion::FrameMeasurements>> measured(images.size(), fail("not measured"));
    run.pool.parallel_for(images.size(), [&](std::size_t i) {
      measured[i] = measure_stored(images[i], camera, extractor, settings);
    });
    for (std::size_t i = first; i < end; ++i) {
      auto& measurements = measured[i - first];
      if (!measurements) {
        return Unexpected(std::move(measurements)
                              .error()
                              .in(fmt::format("{}: key-frame {}", home.file(), keyframes[i].id)));
      }
      result.push_back({keyframes[i].id, keyframes[i].frame_index, keyframes[i].timestamp_ns,
                        *std::move(measurements)});
    }
    run.progress.advance(end, "");
  }
  run.progress.end();
  return result;
}

}  // namespace roomwise::pipeline
