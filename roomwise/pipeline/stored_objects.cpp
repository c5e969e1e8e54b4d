#include <algorithm>
#include <ranges>
#include <set>

#include "roomwise/image/codec.h"
#include "roomwise/objects/center_point.h"
#include "roomwise/objects/instances.h"
#include "roomwise/pipeline/keyframe_images.h"
#include "roomwise/pipeline/stored_map.h"

namespace roomwise::pipeline {
namespace {

std::map<home::KeyframeId, home::KeyframePose> poses_by_id(
    std::span<const home::Keyframe> keyframes) {
  std::map<home::KeyframeId, home::KeyframePose> poses;
  for (const home::Keyframe& keyframe : keyframes) poses[keyframe.id] = keyframe.pose;
  return poses;
}

// Those before which the walk went on from an earlier key-frame than the last: their first step
// leads to that one.
std::set<home::KeyframeId> after_known_ground(std::span<const mapping::PoseGraphEdge> edges) {
  std::set<home::KeyframeId> after;
  for (const mapping::PoseGraphEdge& edge : edges) {
    if (!edge.is_loop && edge.from + 1 != edge.to) after.insert(edge.to);
  }
  return after;
}

// What the newest network that names things said of each key-frame, in the home's words.
Expected<std::map<home::KeyframeId, std::vector<objects::Sighting>>> said_of_pictures(
    const home::Home& home, const objects::ObjectVocabulary& vocabulary, double least_score) {
  std::map<home::KeyframeId, std::vector<objects::Sighting>> said;
  ROOMWISE_TRY(const auto networks, home.networks());
  for (const auto& [id, network] : networks | std::views::reverse) {
    if (network.labels.empty()) continue;
    ROOMWISE_TRY(const auto predictions, home.predictions(id));
    for (const auto& [keyframe, prediction] : predictions) {
      said[keyframe] =
          objects::sightings_in(prediction.scores, network.labels, vocabulary, least_score);
    }
    break;
  }
  return said;
}

// The paper's way, from what the networks said of whole pictures.
Expected<std::uint64_t> update_by_rules(home::Home& home, const objects::ObjectRules& rules) {
  ROOMWISE_TRY(const rooms::Concepts concepts, home.concepts());
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(const auto recordings, home.recordings());
  ROOMWISE_TRY(const auto said, said_of_pictures(home, concepts.vocabulary, rules.least_score));

  ROOMWISE_TRY(const auto edges, home.edges());
  const std::set<home::KeyframeId> not_continuous = after_known_ground(edges);

  std::vector<objects::KeyframeView> views;
  for (const home::Keyframe& keyframe : keyframes) {
    objects::KeyframeView& view = views.emplace_back();
    view.keyframe_id = keyframe.id;
    view.is_continuous = !not_continuous.contains(keyframe.id);
    if (const auto found = said.find(keyframe.id); found != said.end()) {
      view.sightings = found->second;
    }
    if (view.sightings.empty()) continue;
    ROOMWISE_TRY(const home::KeyframeImages images, home.images(keyframe.id));
    ROOMWISE_TRY(const image::DepthImage depth, image::decode_depth(images.depth));
    const auto recording =
        std::ranges::find(recordings, keyframe.recording, &home::StoredRecording::id);
    view.center_point = objects::center_point(depth, recording->recording.camera);
  }
  // Pieces of the map that nothing joined have nothing to do with each other.
  std::map<std::uint64_t, std::vector<objects::KeyframeView>> views_of_piece;
  for (std::size_t i = 0; i < keyframes.size(); ++i)
    views_of_piece[keyframes[i].pose.piece].push_back(views[i]);
  const std::map<home::KeyframeId, home::KeyframePose> poses = poses_by_id(keyframes);
  std::vector<objects::MapObject> found;
  for (const auto& [piece, views_there] : views_of_piece) {
    const auto there = objects::confirm_objects(
        views_there, rules, [&](std::uint64_t id) { return poses.at(id).world_from_keyframe; });
    found.insert(found.end(), there.begin(), there.end());
  }
  ROOMWISE_CHECK_OK(home.atomically([&]() -> Expected<void> {
    for (const objects::KeyframeView& view : views) {
      ROOMWISE_CHECK_OK(home.put_sightings(view.keyframe_id, view.sightings));
    }
    return home.replace_objects(found);
  }));
  return found.size();
}

// The looks of all finders at one key-frame, together.
Expected<std::map<home::KeyframeId, objects::KeyframeLook>> looks_of_all(const home::Home& home) {
  std::map<home::KeyframeId, objects::KeyframeLook> all;
  ROOMWISE_TRY(const auto finders, home.region_finders());
  for (const auto& [id, finder] : finders) {
    ROOMWISE_TRY(auto looks, home.looks(id));
    for (auto& [keyframe, look] : looks) {
      objects::KeyframeLook& joined = all[keyframe];
      joined.coarse_depth = std::move(look.coarse_depth);
      std::ranges::move(look.regions, std::back_inserter(joined.regions));
    }
  }
  return all;
}

// The regions that the home has a word for.
std::vector<objects::NamedRegion> named(const objects::KeyframeLook& look,
                                        const objects::ObjectVocabulary& vocabulary) {
  std::vector<objects::NamedRegion> regions;
  for (const objects::Region& region : look.regions) {
    if (auto name = vocabulary.object_of(region.label)) {
      regions.push_back({*std::move(name), &region});
    }
  }
  return regions;
}

Expected<std::uint64_t> update_instances(home::Home& home) {
  ROOMWISE_TRY(const rooms::Concepts concepts, home.concepts());
  ROOMWISE_TRY(const auto cameras, recording_cameras(home));
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(const auto looks, looks_of_all(home));
  constexpr double kLeastSaid = 0.1;
  ROOMWISE_TRY(const auto said, said_of_pictures(home, concepts.vocabulary, kLeastSaid));
  std::map<std::uint64_t, std::vector<objects::LookedKeyframe>> looked_in_piece;
  for (const home::Keyframe& keyframe : keyframes) {
    const auto look = looks.find(keyframe.id);
    if (look == looks.end()) continue;
    looked_in_piece[keyframe.pose.piece].push_back(
        {.keyframe_id = keyframe.id,
         .world_from_camera = keyframe.pose.world_from_keyframe,
         .camera = &cameras.at(keyframe.recording),
         .coarse_depth = &look->second.coarse_depth,
         .regions = named(look->second, concepts.vocabulary),
         .said = {}});
    if (const auto words = said.find(keyframe.id); words != said.end()) {
      looked_in_piece[keyframe.pose.piece].back().said = words->second;
    }
  }
  std::vector<objects::Instance> instances;
  for (const auto& [piece, looked] : looked_in_piece) {
    const auto there = objects::find_instances(looked, objects::find_level(looked), {});
    instances.insert(instances.end(), there.begin(), there.end());
  }
  ROOMWISE_CHECK_OK(home.replace_instances(instances));
  return instances.size();
}

}  // namespace

Expected<FoundObjects> update_objects(home::Home& home, const objects::ObjectRules& rules) {
  ROOMWISE_CHECK_OK(rules.validate());
  FoundObjects found;
  ROOMWISE_CHECK_OK(home.atomically([&]() -> Expected<void> {
    ROOMWISE_TRY(found.by_rules, update_by_rules(home, rules));
    ROOMWISE_TRY(found.instances, update_instances(home));
    return {};
  }));
  return found;
}

}  // namespace roomwise::pipeline
