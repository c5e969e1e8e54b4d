#include "roomwise/pipeline/exports/home_contents.h"

#include <algorithm>

#include "roomwise/pipeline/rooms/home_layout.h"
#include "roomwise/pipeline/stored/stored_edits.h"

namespace roomwise::pipeline {
namespace {

Expected<std::vector<WalkContent>> walks_of(const home::Home& home,
                                            std::span<const home::Keyframe> keyframes) {
  std::vector<WalkContent> walks;
  ROOMWISE_TRY(const auto recordings, walks_that_stay(home));
  for (const home::StoredRecording& stored : recordings) {
    WalkContent& walk = walks.emplace_back();
    walk.stored = stored;
    std::ranges::copy_if(
        keyframes, std::back_inserter(walk.keyframes),
        [&](const home::Keyframe& keyframe) { return keyframe.recording == stored.id; });
    ROOMWISE_TRY(const auto frames, home.frames(stored.id));
    walk.frames = frames.size();
    walk.placed =
        static_cast<std::uint64_t>(std::ranges::count_if(frames, [&](const home::Frame& frame) {
          return frame.place && keyframes[frame.place->keyframe].pose.component == 0;
        }));
  }
  return walks;
}

Expected<std::vector<ThingContent>> things_of(const home::Home& home,
                                              std::span<const home::Keyframe> keyframes,
                                              const HomeContents& contents) {
  std::vector<ThingContent> things;
  ROOMWISE_TRY(const HomeThings home_things, find_home_things(home));
  ROOMWISE_TRY(const HomeHistory history, find_home_history(home, home_things));
  ROOMWISE_TRY(const auto visits, home.visits());
  const rooms::RoomLayout* const layout = contents.layout ? &*contents.layout : nullptr;
  for (const HomeThing& instance : home_things.things) {
    const home::KeyframePose& pose = keyframes[instance.keyframe_id].pose;
    ThingContent& thing = things.emplace_back();
    thing.instance = instance;
    thing.component = pose.component;
    if (pose.component == 0) {
      thing.box_gravity =
          instance.box_world(contents.gravity_from_world() * pose.world_from_keyframe);
    }
    thing.note = instance.note;
    thing.is_confirmed = instance.is_confirmed;
    thing.room =
        room_of_thing(middle_on_map(instance, pose, contents.floor.frame), instance.keyframe_id,
                      layout, contents.keyframe_rooms, instance.room);
    if (const ThingHistory* const seen = history.of(instance)) {
      thing.first_seen = seen->first_seen;
      thing.last_seen = seen->last_seen;
    }
    if (instance.visit != 0) thing.visit = visits.at(instance.visit).name;
  }
  return things;
}

}  // namespace

std::size_t HomeContents::keyframes_apart() const {
  std::size_t count = 0;
  for (const WalkContent& walk : walks) {
    count += static_cast<std::size_t>(std::ranges::count_if(
        walk.keyframes,
        [](const home::Keyframe& keyframe) { return keyframe.pose.component != 0; }));
  }
  return count;
}

std::size_t HomeContents::things_apart() const {
  return static_cast<std::size_t>(std::ranges::count_if(
      things, [](const ThingContent& thing) { return thing.component != 0; }));
}

Expected<HomeContents> read_home_contents(const home::Home& home, RunContext& run) {
  HomeContents contents;
  ROOMWISE_TRY(contents.floor, find_home_floor(home, run));
  ROOMWISE_TRY(contents.rooms, home.rooms());
  if (contents.floor.grid && !contents.rooms.empty()) {
    ROOMWISE_TRY(contents.layout,
                 find_room_layout(home, contents.floor.frame, *contents.floor.grid));
  }
  ROOMWISE_TRY(contents.keyframe_rooms, rooms_of_keyframes(home));
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(contents.walks, walks_of(home, keyframes));
  ROOMWISE_TRY(contents.things, things_of(home, keyframes, contents));
  return contents;
}

}  // namespace roomwise::pipeline
