#include "roomwise/pipeline/objects/stored_detections.h"

#include <algorithm>
#include <array>
#include <set>

#include "roomwise/objects/detection/region_finder.h"
#include "roomwise/pipeline/stored/keyframe_images.h"

namespace roomwise::pipeline {
namespace {

using objects::RegionSource;
constexpr std::array kSources{RegionSource::kDetector, RegionSource::kCrop, RegionSource::kProposal,
                              RegionSource::kActivation};

// The looks of all finders at one key-frame, together; of several finders of one name that looked
// at it the newest counts.
struct AllLooks {
  std::map<home::KeyframeId, objects::KeyframeDetections> looks;
  std::map<home::KeyframeId, std::set<RegionSource>> sources;
};
Expected<AllLooks> looks_of_all(const home::Home& home) {
  std::map<std::string, std::map<home::KeyframeId, objects::KeyframeDetections>> newest;  // by name
  AllLooks all;
  ROOMWISE_TRY(const auto finders, home.region_finders());
  for (const auto& [id, finder] : finders) {
    ROOMWISE_TRY(auto looks, home.looks(id));
    const RegionSource source = objects::source_of(finder.fingerprint);
    for (auto& [keyframe, look] : looks) {
      all.sources[keyframe].insert(source);
      for (objects::Region& region : look.regions) region.source = source;
      newest[finder.name][keyframe] = std::move(look);
    }
  }
  for (auto& [name, looks] : newest) {
    for (auto& [keyframe, look] : looks) {
      objects::KeyframeDetections& joined = all.looks[keyframe];
      joined.coarse_depth = std::move(look.coarse_depth);
      std::ranges::move(look.regions, std::back_inserter(joined.regions));
    }
  }
  return all;
}

}  // namespace

Expected<std::map<home::KeyframeId, std::vector<objects::Observation>>> said_of_pictures(
    const home::Home& home, const objects::ObjectVocabulary& vocabulary, double min_score) {
  std::map<home::KeyframeId, std::vector<objects::Observation>> said;
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

std::vector<objects::NamedRegion> named_regions(const objects::KeyframeDetections& look,
                                                const objects::ObjectVocabulary& vocabulary) {
  static const auto look_alikes = objects::ObjectVocabulary::look_alikes();
  std::vector<objects::NamedRegion> regions;
  for (const objects::Region& region : look.regions) {
    if (auto name = vocabulary.object_of(region.label)) {
      regions.push_back({*std::move(name), &region});
    } else if (auto look_alike = look_alikes.object_of(region.label)) {
      regions.push_back({*std::move(look_alike), &region, /*is_in_vocabulary=*/false});
    }
  }
  return regions;
}

Expected<StoredDetections> StoredDetections::read(const home::Home& home) {
  StoredDetections stored;
  ROOMWISE_TRY(const rooms::Concepts concepts, home.concepts());
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(stored.cameras_, recording_cameras(home));
  ROOMWISE_TRY(AllLooks all, looks_of_all(home));
  stored.looks_ = std::move(all.looks);
  constexpr double kMinSaid = 0.1;
  ROOMWISE_TRY(const auto said, said_of_pictures(home, concepts.vocabulary, kMinSaid));
  for (const home::Keyframe& keyframe : keyframes) {
    const auto look = stored.looks_.find(keyframe.id);
    if (look == stored.looks_.end()) continue;
    objects::ObservedKeyframe& looked = stored.components_[keyframe.pose.component].emplace_back();
    looked.keyframe_id = keyframe.id;
    looked.world_from_camera = keyframe.pose.world_from_keyframe;
    looked.camera = &stored.cameras_.at(keyframe.recording);
    looked.coarse_depth = &look->second.coarse_depth;
    looked.regions = named_regions(look->second, concepts.vocabulary);
    for (const RegionSource source : kSources) {
      if (!all.sources.at(keyframe.id).contains(source)) looked.not_asked.insert(source);
    }
    if (const auto words = said.find(keyframe.id); words != said.end()) looked.said = words->second;
  }
  return stored;
}

}  // namespace roomwise::pipeline
