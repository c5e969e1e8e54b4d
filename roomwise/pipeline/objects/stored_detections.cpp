#include "roomwise/pipeline/objects/stored_detections.h"

#include <algorithm>
#include <array>
#include <set>

#include "roomwise/objects/detection/region_finder.h"
#include "roomwise/pipeline/stored/keyframe_images.h"
#include "roomwise/pipeline/stored/stored_map.h"

namespace roomwise::pipeline {
namespace {

using objects::DetectionSource;
constexpr std::array kSources{DetectionSource::kDetector, DetectionSource::kProposal};

// What all finders detected in the key-frames, together, and which of the sources looked at each;
// of several finders of one name that looked at it the newest counts.
struct AllDetections {
  std::map<home::KeyframeId, objects::KeyframeDetections> of_keyframe;
  std::map<home::KeyframeId, std::set<DetectionSource>> sources;
};
Expected<AllDetections> all_detections(const home::Home& home) {
  std::map<std::string, std::map<home::KeyframeId, objects::KeyframeDetections>> newest;  // by name
  AllDetections all;
  ROOMWISE_TRY(const auto finders, home.region_finders());
  for (const auto& [id, finder] : finders) {
    const auto source = objects::source_of(finder.fingerprint);
    if (!source) continue;
    ROOMWISE_TRY(auto looks, home.detections(id));
    for (auto& [keyframe, look] : looks) {
      all.sources[keyframe].insert(*source);
      for (objects::Detection& detection : look.detections) detection.source = *source;
      newest[finder.name][keyframe] = std::move(look);
    }
  }
  for (auto& [name, looks] : newest) {
    for (auto& [keyframe, look] : looks) {
      objects::KeyframeDetections& joined = all.of_keyframe[keyframe];
      joined.coarse_depth = std::move(look.coarse_depth);
      std::ranges::move(look.detections, std::back_inserter(joined.detections));
    }
  }
  return all;
}

}  // namespace

Expected<std::map<home::KeyframeId, std::vector<objects::ObjectScore>>> said_of_pictures(
    const home::Home& home, const objects::ObjectVocabulary& vocabulary, double min_score) {
  std::map<home::KeyframeId, std::vector<objects::ObjectScore>> said;
  ROOMWISE_TRY(const auto networks, home.networks());
  // One that was interrupted has not looked at all: what was said before stands elsewhere.
  for (const auto& [id, network] : networks) {
    if (network.labels.empty()) continue;
    ROOMWISE_TRY(const auto predictions, home.predictions(id));
    for (const auto& [keyframe, prediction] : predictions) {
      said[keyframe] =
          objects::observations_in(prediction.scores, network.labels, vocabulary, min_score);
    }
  }
  return said;
}

Expected<std::map<std::uint64_t, std::vector<objects::ObservedKeyframe>>> observed_keyframes(
    const home::Home& home) {
  ROOMWISE_TRY(const rooms::Concepts concepts, home.concepts());
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(const auto cameras, recording_cameras(home));
  ROOMWISE_TRY(AllDetections all, all_detections(home));
  ROOMWISE_TRY(const auto gravity, stored_gravity(home, keyframes));
  std::map<std::uint64_t, std::vector<objects::ObservedKeyframe>> components;
  for (const home::Keyframe& keyframe : keyframes) {
    const auto found = all.of_keyframe.find(keyframe.id);
    if (found == all.of_keyframe.end()) continue;
    objects::ObservedKeyframe& observed = components[keyframe.pose.component].emplace_back();
    observed.coarse_depth = std::move(found->second.coarse_depth);
    observed.detections =
        objects::classified(std::move(found->second.detections), concepts.vocabulary);
    observed.keyframe_id = keyframe.id;
    observed.world_from_camera = keyframe.pose.world_from_keyframe;
    observed.camera = cameras.at(keyframe.recording);
    if (const auto up = gravity.find(keyframe.id); up != gravity.end())
      observed.up_world = up->second;
    for (const DetectionSource source : kSources) {
      if (!all.sources.at(keyframe.id).contains(source)) observed.sources_not_run.insert(source);
    }
  }
  return components;
}

}  // namespace roomwise::pipeline
