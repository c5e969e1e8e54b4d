#include <algorithm>
#include <set>

#include "roomwise/base/calendar_time.h"
#include "roomwise/image/codec.h"
#include "roomwise/objects/changes/changes.h"
#include "roomwise/objects/instances/center_point.h"
#include "roomwise/pipeline/objects/stored_detections.h"
#include "roomwise/pipeline/objects/thing_history.h"
#include "roomwise/pipeline/stored/keyframe_images.h"
#include "roomwise/pipeline/stored/stored_map.h"

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
    if (!edge.is_robust && edge.from + 1 != edge.to) after.insert(edge.to);
  }
  return after;
}

// The paper's way, from what the networks said of whole pictures.
Expected<std::uint64_t> update_by_rules(home::Home& home, const objects::ObjectRules& rules,
                                        const std::shared_ptr<LostPictures>& lost) {
  ROOMWISE_TRY(const rooms::Concepts concepts, home.concepts());
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(const auto recordings, home.recordings());
  ROOMWISE_TRY(const auto said, said_of_pictures(home, concepts.vocabulary, rules.min_score));

  ROOMWISE_TRY(const auto edges, home.edges());
  const std::set<home::KeyframeId> not_continuous = after_known_ground(edges);

  std::vector<objects::KeyframeView> views;
  for (const home::Keyframe& keyframe : keyframes) {
    objects::KeyframeView& view = views.emplace_back();
    view.keyframe_id = keyframe.id;
    // Nor does a walk go on from where the one before it ended.
    const bool begins_walk =
        views.size() > 1 && keyframes[views.size() - 2].recording != keyframe.recording;
    view.is_continuous = !begins_walk && !not_continuous.contains(keyframe.id);
    if (const auto found = said.find(keyframe.id); found != said.end()) {
      view.observations = found->second;
    }
    if (view.observations.empty()) continue;
    const auto depth = home.images(keyframe.id).and_then([](const home::KeyframeImages& images) {
      return image::decode_depth(images.depth);
    });
    if (!depth) {
      ROOMWISE_RETURN_IF_ERROR(go_on_without(home, keyframe.id, depth.error(), lost));
      continue;
    }
    const auto recording =
        std::ranges::find(recordings, keyframe.recording, &home::StoredRecording::id);
    view.center_point = objects::center_point(*depth, recording->recording.camera);
  }
  // Components of the map that nothing joined have nothing to do with each other.
  std::map<std::uint64_t, std::vector<objects::KeyframeView>> views_of_component;
  for (std::size_t i = 0; i < keyframes.size(); ++i)
    views_of_component[keyframes[i].pose.component].push_back(views[i]);
  const std::map<home::KeyframeId, home::KeyframePose> poses = poses_by_id(keyframes);
  std::vector<objects::ConfirmedObject> found;
  for (const auto& [component, views_there] : views_of_component) {
    const auto there = objects::confirm_objects(
        views_there, rules, [&](std::uint64_t id) { return poses.at(id).world_from_keyframe; });
    found.insert(found.end(), there.begin(), there.end());
  }
  ROOMWISE_RETURN_IF_ERROR(home.atomically([&]() -> Expected<void> {
    for (const objects::KeyframeView& view : views) {
      ROOMWISE_RETURN_IF_ERROR(home.put_observations(view.keyframe_id, view.observations));
    }
    return home.replace_confirmed_objects(found);
  }));
  return found.size();
}

// Whether a walk, by its stamps, saw a thing after a visit was over. False where stamps do not tell
// the date.
bool is_after(const Sighting& seen, const home::Visit& visit) {
  return calendar_time(seen.time_ns) && calendar_time(visit.last_timestamp_ns) &&
         seen.time_ns > visit.last_timestamp_ns;
}

// What walks show, without what visits know to be past unless a later walk saw it there again, and
// with what visits brought.
Expected<std::vector<objects::Instance>> as_visits_left_it(
    const home::Home& home, const HomeHistory& history,
    const std::map<home::KeyframeId, home::KeyframePose>& poses) {
  std::vector<objects::Instance> joined;
  std::vector<Sighting> last_seen;  // of each
  for (const ThingHistory& one : history.things) {
    if (one.is_gone) continue;
    joined.push_back(one.as_it_stands());
    last_seen.push_back(one.last_seen);
  }
  const auto standing = [&](const objects::Instance& one) {
    return objects::PlacedInstance{
        one.name, one.box_world(poses.at(one.keyframe_id).world_from_keyframe), {}};
  };
  const auto component_of = [&](const objects::Instance& one) {
    return poses.at(one.keyframe_id).component;
  };
  ROOMWISE_TRY(const auto past, home.past_instances());
  ROOMWISE_TRY(const auto visits, home.visits());
  std::vector<objects::PlacedInstance> gone, there;
  std::vector<home::VisitId> noticed_by;  // of what is gone
  for (const home::PastInstance& one : past) {
    // What a visit brought and another took away was never joined from key-frames.
    if (one.instance.visit == 0 && component_of(one.instance) == 0) {
      gone.push_back(standing(one.instance));
      noticed_by.push_back(one.noticed_by);
    }
  }
  std::vector<std::size_t> places;  // in joined, of what is there
  for (std::size_t i = 0; i < joined.size(); ++i) {
    if (component_of(joined[i]) != 0) continue;
    places.push_back(i);
    there.push_back(standing(joined[i]));
  }
  std::set<std::size_t> left_out;
  const auto matches = objects::match_by_name_and_place(gone, there);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (!matches[i]) continue;
    const std::size_t place = places[*matches[i]];
    if (!is_after(last_seen[place], visits.at(noticed_by[i]))) left_out.insert(place);
  }
  std::vector<objects::Instance> instances;
  for (std::size_t i = 0; i < joined.size(); ++i) {
    if (!left_out.contains(i)) instances.push_back(std::move(joined[i]));
  }
  ROOMWISE_TRY(const auto stored, home.instances());
  std::ranges::copy_if(stored, std::back_inserter(instances),
                       [](const objects::Instance& one) { return one.visit != 0; });
  return instances;
}

Expected<std::uint64_t> update_instances(home::Home& home) {
  ROOMWISE_TRY(const HomeHistory history, follow_things(home));
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(const auto instances, as_visits_left_it(home, history, poses_by_id(keyframes)));
  ROOMWISE_RETURN_IF_ERROR(home.replace_instances(instances));
  ROOMWISE_RETURN_IF_ERROR(keep_home_history(home, history));
  return instances.size();
}

}  // namespace

Expected<FoundObjects> update_objects(home::Home& home, const objects::ObjectRules& rules,
                                      const std::shared_ptr<LostPictures>& lost) {
  ROOMWISE_RETURN_IF_ERROR(rules.validate());
  FoundObjects found;
  ROOMWISE_RETURN_IF_ERROR(home.atomically([&]() -> Expected<void> {
    ROOMWISE_TRY(found.by_rules, update_by_rules(home, rules, lost));
    ROOMWISE_TRY(found.instances, update_instances(home));
    return {};
  }));
  return found;
}

}  // namespace roomwise::pipeline
