#include "roomwise/live/view/home_view.h"

#include <algorithm>
#include <filesystem>
#include <ranges>
#include <set>

#include "roomwise/guide/answers/spot_prompts.h"
#include "roomwise/pipeline/edits/undo_edit.h"
#include "roomwise/pipeline/objects/thing_history.h"
#include "roomwise/pipeline/rooms/home_layout.h"
#include "roomwise/pipeline/stored/stored_rooms.h"

namespace roomwise::live {
namespace {

Expected<void> view_walks(const home::Home& home, HomeView& view) {
  ROOMWISE_TRY(const auto recordings, home.recordings());
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(const pipeline::KeyframeRooms rooms, pipeline::rooms_of_keyframes(home));
  for (const home::StoredRecording& recording : recordings) {
    ROOMWISE_TRY(recording::RoomLabels labels, home.room_ranges(recording.id));
    ViewedWalk walk{recording, 0, std::move(labels)};
    for (const home::Keyframe& keyframe : keyframes) {
      if (keyframe.recording != recording.id) continue;
      ++walk.keyframes;
      const auto room = rooms.find(keyframe.id);
      view.keyframes.push_back({keyframe, room != rooms.end() ? room->second : std::string(),
                                keyframe.pose.component == 0});
    }
    view.walks.push_back(std::move(walk));
  }
  std::ranges::sort(view.keyframes, {}, [](const ViewedKeyframe& one) { return one.keyframe.id; });
  return {};
}

// Places instances on the map and in rooms, as far as these are known.
class ThingPlacer {
 public:
  explicit ThingPlacer(const HomeView& view) : view_(view) {
    for (const ViewedKeyframe& one : view.keyframes) {
      keyframes_[one.keyframe.id] = &one.keyframe;
      if (!one.room.empty()) rooms_[one.keyframe.id] = one.room;
    }
  }

  // Seen when its key-frame was.
  [[nodiscard]] guide::KnownThing own_thing(const home::OwnThing& stored) const {
    const home::OwnThingSighting& seen = stored.last_seen;
    guide::KnownThing thing;
    thing.name = stored.name;
    thing.probability = 1;
    thing.is_taught = true;
    if (seen.seen_s) thing.seen = calendar_time(*seen.seen_s * 1'000'000'000);
    thing.room = seen.room;
    const auto keyframe = seen.keyframe ? keyframes_.find(*seen.keyframe) : keyframes_.end();
    if (keyframe == keyframes_.end()) return thing;
    if (view_.map && seen.middle_keyframe) {
      thing.position_plan = view_.map->frame.on_plan(keyframe->second->pose.world_from_keyframe *
                                                     *seen.middle_keyframe);
    }
    const auto by_place = pipeline::room_of_thing(thing.position_plan, *seen.keyframe,
                                                  view_.layout ? &*view_.layout : nullptr, rooms_);
    if (by_place) thing.room = by_place;
    return thing;
  }
  [[nodiscard]] guide::KnownThing known_thing(const pipeline::HomeThing& one) const {
    guide::KnownThing thing = known_thing(one, one.room);
    thing.note = one.note;
    thing.added_by_edit = one.added_by_edit;
    thing.is_confirmed = one.is_confirmed;
    return thing;
  }
  // `put_in`: where somebody put it, where the floor does not tell.
  [[nodiscard]] guide::KnownThing known_thing(
      const objects::Instance& instance,
      const std::optional<std::string>& put_in = std::nullopt) const {
    guide::KnownThing thing;
    static_cast<objects::Instance&>(thing) = instance;
    const auto keyframe = keyframes_.find(instance.keyframe_id);
    const bool is_known = keyframe != keyframes_.end();
    if (is_known) thing.seen = calendar_time(keyframe->second->timestamp_ns);
    if (view_.map && is_known) {
      const home::KeyframePose& pose = keyframe->second->pose;
      thing.position_plan = pipeline::middle_on_map(instance, pose, view_.map->frame);
      const Eigen::Vector3d along =
          view_.map->frame.gravity_from_world.rotation *
          (instance.box_world(pose.world_from_keyframe).world_from_box.rotation *
           Eigen::Vector3d::UnitX());
      thing.yaw_rad = std::atan2(along.y(), along.x());
    }
    thing.room = pipeline::room_of_thing(thing.position_plan, instance.keyframe_id,
                                         view_.layout ? &*view_.layout : nullptr, rooms_, put_in);
    return thing;
  }

 private:
  const HomeView& view_;
  std::map<home::KeyframeId, const home::Keyframe*> keyframes_;
  pipeline::KeyframeRooms rooms_;
};

Expected<void> view_edits(const home::Home& home, const pipeline::HomeThings& things,
                          HomeView& view) {
  ROOMWISE_TRY(const auto edits, pipeline::stored_edits(home));
  for (const pipeline::StoredEdit& edit : edits | std::views::reverse) {
    const auto lost = things.without_effect.find(edit.id);
    view.edits.push_back({edit, lost == things.without_effect.end() ? "" : lost->second,
                          pipeline::why_not_undone(edits, edit, things)});
  }
  return {};
}

Expected<void> view_things(const home::Home& home, const pipeline::HomeThings& things,
                           const pipeline::HomeHistory& history, HomeView& view) {
  ROOMWISE_TRY(const auto visits, home.visits());
  const ThingPlacer placer(view);
  for (const pipeline::HomeThing& instance : things.things) {
    guide::KnownThing thing = placer.known_thing(instance);
    if (instance.added_by_edit != 0) {
      thing.seen = std::nullopt;  // no walk saw it
    } else if (const pipeline::ThingHistory* told = history.of(instance)) {
      thing.seen = calendar_time(told->last_seen.time_ns);
    } else if (instance.visit != 0) {
      thing.seen = calendar_time(visits.at(instance.visit).last_timestamp_ns);
    }
    view.things.push_back(std::move(thing));
  }
  return {};
}

Expected<void> view_own_things(const home::Home& home, HomeView& view) {
  ROOMWISE_TRY(const auto things, home.own_things());
  const ThingPlacer placer(view);
  for (const home::OwnThing& thing : things) {
    view.own_things.push_back({thing, placer.own_thing(thing)});
  }
  return {};
}

// Whether the last visit is what looked at the home last.
bool is_visit_newest(const std::map<home::VisitId, home::Visit>& visits,
                     const pipeline::HomeHistory& history, const HomeView& view) {
  if (visits.empty()) return false;
  if (history.walks.size() < 2) return true;  // one walk alone changes nothing
  TimestampNs walked_ns = 0;
  for (const ViewedKeyframe& one : view.keyframes) {
    if (one.keyframe.recording == history.walks.back())
      walked_ns = std::max(walked_ns, one.keyframe.timestamp_ns);
  }
  const TimestampNs visited_ns = visits.rbegin()->second.last_timestamp_ns;
  return calendar_time(walked_ns) && calendar_time(visited_ns) && visited_ns > walked_ns;
}

// What a visit changed. A thing that it moved is one that it brought and one that is past.
// `things`: of the home, those of the view as they were found.
guide::ChangedThings changed_by_visit(home::VisitId visit, std::span<const home::PastInstance> past,
                                      const pipeline::HomeThings& things, const HomeView& view) {
  const ThingPlacer placer(view);
  guide::ChangedThings changed;
  std::vector<std::string> found_as;  // of those that arrived
  for (std::size_t i = 0; i < view.things.size(); ++i) {
    if (view.things[i].visit != visit) continue;
    changed.arrived.push_back(view.things[i]);
    found_as.push_back(things.things[i].found_as);
  }
  for (const home::PastInstance& one : past) {
    if (one.noticed_by != visit) continue;
    const auto now = std::ranges::find(found_as, one.instance.name);
    if (one.reason == home::PastReason::kMoved && now != found_as.end()) {
      const auto arrived = changed.arrived.begin() + (now - found_as.begin());
      changed.moved.push_back(std::move(*arrived));
      changed.arrived.erase(arrived);
      found_as.erase(now);
      continue;
    }
    const auto name = things.name_of_gone(one.instance);
    if (!name) continue;
    changed.gone.push_back(placer.known_thing(one.instance));
    changed.gone.back().name = *name;
    changed.gone.back().seen = calendar_time(one.last_seen_ns);
  }
  return changed;
}

guide::ChangedThings changed_by_walk(home::RecordingId walk, const pipeline::HomeHistory& history,
                                     const HomeView& view) {
  using pipeline::ThingEvent;
  const ThingPlacer placer(view);
  guide::ChangedThings changed;
  for (const guide::KnownThing& thing : view.things) {
    const pipeline::ThingHistory* const told = history.of(thing);
    if (told == nullptr || told->events.back().walk != walk) continue;
    const ThingEvent what = told->events.back().what;
    if (what == ThingEvent::kNew) changed.arrived.push_back(thing);
    if (what == ThingEvent::kMoved) changed.moved.push_back(thing);
    if (what == ThingEvent::kShifted) changed.shifted.push_back(thing);
  }
  for (const pipeline::ThingHistory& told : history.things) {
    if (!told.is_gone || told.events.back().walk != walk) continue;
    changed.gone.push_back(placer.known_thing(told.thing));
    changed.gone.back().seen = calendar_time(told.last_seen.time_ns);
  }
  return changed;
}

Expected<void> view_latest(const home::Home& home, const pipeline::HomeThings& things,
                           const pipeline::HomeHistory& history, HomeView& view) {
  ROOMWISE_TRY(const auto visits, home.visits());
  if (is_visit_newest(visits, history, view)) {
    ROOMWISE_TRY(const auto past, home.past_instances());
    view.latest = changed_by_visit(visits.rbegin()->first, past, things, view);
  } else if (history.walks.size() > 1) {
    view.latest = changed_by_walk(history.walks.back(), history, view);
  }
  return {};
}

void view_changes(const pipeline::HomeHistory& history, HomeView& view) {
  if (history.walks.size() < 2 || history.things.empty()) return;
  pipeline::KeyframeRooms rooms;
  std::vector<home::Keyframe> keyframes;
  for (const ViewedKeyframe& one : view.keyframes) {
    keyframes.push_back(one.keyframe);
    if (!one.room.empty()) rooms[one.keyframe.id] = one.room;
  }
  ViewedChanges& changes = view.changes.emplace();
  changes.walk = history.walks.back();
  changes.since = history.walks.end()[-2];
  for (const auto& [thing, event] : history.changes_by(changes.walk)) {
    std::optional<Eigen::Vector3d> middle;
    if (view.map) {
      middle = pipeline::middle_on_map(thing->thing, keyframes[thing->thing.keyframe_id].pose,
                                       view.map->frame);
    }
    changes.things.push_back({std::string(pipeline::to_string(event->what)), thing->thing.name,
                              pipeline::room_of_thing(middle, thing->thing.keyframe_id,
                                                      view.layout ? &*view.layout : nullptr, rooms),
                              pipeline::moved_m(*thing, *event, keyframes)});
  }
}

// People name a room a step early or late, and no floor tells where it ends: it is probable only.
std::optional<rooms::RoomScore> room_by_walks(const HomeView& view,
                                              const Eigen::Vector3d& point_plan) {
  constexpr double kAbout_m = 1, kProbable = 0.8;
  std::set<std::string> names;
  for (const ViewedKeyframe& one : view.keyframes) {
    if (!view.map || !one.on_map) continue;
    const Eigen::Vector3d taken_at =
        view.map->frame.on_plan(one.keyframe.pose.world_from_keyframe).translation;
    if ((taken_at - point_plan).norm() < kAbout_m) names.insert(one.room);
  }
  if (names.size() != 1 || names.begin()->empty()) return std::nullopt;
  return rooms::RoomScore{*names.begin(), kProbable};
}

}  // namespace

namespace {

std::int64_t number_of(const std::string& place) {
  const std::string digest =
      sha256_hex({reinterpret_cast<const std::uint8_t*>(place.data()), place.size()});
  constexpr std::size_t kDigits = 13;  // hexadecimal: 52 bits
  return std::stoll(digest.substr(0, kDigits), nullptr, 16);
}

}  // namespace

std::int64_t thing_id(const objects::Instance& instance) {
  const network::PixelBox& box = instance.picture_box;
  return number_of(fmt::format("{} {} {} {} {}", instance.keyframe_id, box.left, box.top, box.right,
                               box.bottom));
}

std::int64_t thing_id(const pipeline::HomeThing& thing) {
  if (thing.added_by_edit == 0) return thing_id(static_cast<const objects::Instance&>(thing));
  return number_of(fmt::format("added {}", thing.added_by_edit));
}

std::int64_t thing_id(const guide::KnownThing& thing) {
  if (thing.added_by_edit == 0) return thing_id(static_cast<const objects::Instance&>(thing));
  return number_of(fmt::format("added {}", thing.added_by_edit));
}

std::set<home::RecordingId> HomeView::walks_taken_away() const {
  std::set<home::RecordingId> taken;
  for (const ViewedEdit& one : edits) {
    if (one.edit.change.walk) taken.insert(*one.edit.change.walk);
  }
  return taken;
}

std::optional<std::string> HomeView::room_at(const Eigen::Vector3d& point_plan) const {
  if (!layout) return std::nullopt;
  return layout->room_at(point_plan.head<2>());
}

std::optional<rooms::RoomScore> HomeView::room_around(const Eigen::Vector3d& point_plan,
                                                      double sigma_m) const {
  if (!layout) return room_by_walks(*this, point_plan);
  const std::vector<double> shares = layout->room_probabilities(point_plan.head<2>(), sigma_m);
  const auto best = std::ranges::max_element(shares);
  if (best == shares.end() || *best == 0) return std::nullopt;
  return rooms::RoomScore{layout->rooms()[static_cast<std::size_t>(best - shares.begin())].name,
                          *best};
}

ViewedSpot view_spot(const pipeline::MarkedSpot& spot, const std::string& name,
                     const HomeView& view) {
  ViewedSpot viewed{spot, {}};
  viewed.thing.name = name;
  viewed.thing.probability = 1;
  viewed.thing.is_confirmed = true;  // somebody stood there
  std::vector<home::Keyframe> keyframes;
  for (const ViewedKeyframe& one : view.keyframes) keyframes.push_back(one.keyframe);
  if (!view.map) return viewed;
  viewed.thing.position_plan = pipeline::point_on_plan(spot.place, keyframes, view.map->frame);
  if (!viewed.thing.position_plan) return viewed;
  viewed.thing.room = view.room_at(*viewed.thing.position_plan);
  return viewed;
}

Expected<void> view_spots(const home::Home& home, HomeView& view) {
  view.marked.clear();
  ROOMWISE_TRY(const auto spots, pipeline::marked_spots(home));
  for (const pipeline::MarkedSpot& spot : spots) {
    const std::string name = spot.name.empty() ? guide::kRememberedPlace : spot.name;
    view.marked.push_back(view_spot(spot, name, view));
  }
  return {};
}

std::vector<rooms::Doorway> doorways_of(const HomeView& home) {
  return home.layout ? home.layout->doorways() : std::vector<rooms::Doorway>{};
}

guide::HomeMap map_of(const HomeView& home, std::span<const rooms::Doorway> doorways) {
  guide::HomeMap map;
  if (home.map && home.map->floor) map.floor = &*home.map->floor;
  if (home.layout) map.layout = &*home.layout;
  if (home.map) map.storeys = &home.map->frame.storeys;
  map.doorways = doorways;
  map.things = home.things;
  return map;
}

Expected<std::shared_ptr<const HomeView>> view_home(
    const home::Home& home, const pipeline::Networks& networks, std::shared_ptr<const LiveMap> map,
    std::shared_ptr<const pipeline::OwnThingWatch> own_thing_watch) {
  HomeView view;
  view.own_thing_watch = std::move(own_thing_watch);
  ROOMWISE_TRY(view.owes_erasing, home.owes_erasing());
  view.name = std::filesystem::path(home.file()).stem().string();
  view.map = std::move(map);
  ROOMWISE_TRY(view.rooms, home.rooms());
  ROOMWISE_TRY(view.concepts, home.concepts());
  for (const auto& [type, objects] : view.concepts.objects_of_room_type) {
    view.room_types.push_back(type);
  }
  ROOMWISE_RETURN_IF_ERROR(view_walks(home, view));
  const bool has_names = std::ranges::any_of(
      view.walks, [](const ViewedWalk& walk) { return !walk.labels.ranges().empty(); });
  if (view.map && view.map->floor && has_names) {
    // Without one the rooms of things are left to the pictures.
    ROOMWISE_TRY(view.layout, pipeline::find_room_layout(home, view.map->frame, *view.map->floor));
  }
  ROOMWISE_TRY(const pipeline::HomeThings things, pipeline::find_home_things(home));
  ROOMWISE_TRY(const pipeline::HomeHistory history, pipeline::find_home_history(home, things));
  ROOMWISE_RETURN_IF_ERROR(view_things(home, things, history, view));
  ROOMWISE_RETURN_IF_ERROR(view_own_things(home, view));
  ROOMWISE_RETURN_IF_ERROR(view_spots(home, view));
  ROOMWISE_RETURN_IF_ERROR(view_edits(home, things, view));
  ROOMWISE_RETURN_IF_ERROR(view_latest(home, things, history, view));
  view_changes(history, view);
  ROOMWISE_TRY(const auto classifier, home.room_classifier());
  if (classifier) {
    view.learned_report = classifier->report_json;
    view.learned_network = classifier->network_name;
  }
  if (!classifier) {
    view.why_no_recognizer = "no rooms were learned yet; name the rooms of a walk, then learn them";
  } else if (auto recognizer = pipeline::RoomRecognizer::create(home, networks)) {
    view.recognizer = std::make_shared<const pipeline::RoomRecognizer>(*std::move(recognizer));
  } else {
    view.why_no_recognizer = recognizer.error().message;
  }
  return std::make_shared<const HomeView>(std::move(view));
}

}  // namespace roomwise::live
