#include "things/thing_places.h"

#include "command_run.h"

namespace roomwise::app {

Expected<ThingPlaces> ThingPlaces::read(const home::Home& home) {
  ThingPlaces places;
  ROOMWISE_TRY(places.named_rooms, pipeline::rooms_of_keyframes(home));
  ROOMWISE_TRY(const std::vector<home::Keyframe> keyframes, home.keyframes());
  for (const home::Keyframe& keyframe : keyframes) places.keyframes[keyframe.id] = keyframe;
  ROOMWISE_TRY(places.rooms, home.keyframe_rooms());
  return places;
}

Expected<void> ThingPlaces::find_layout(const home::Home& home, Context& context) {
  CommandRun run(context);
  auto found = pipeline::find_home_layout(home, run);
  if (found) {
    layout = *std::move(found);
  } else if (found.error().code == ErrorCode::kInterrupted) {
    return Unexpected(std::move(found).error());
  } else {
    context.progress.note(
        fmt::format("rooms are those from which things were seen: {}", found.error().message));
  }
  return {};
}

std::string ThingPlaces::room_of(home::KeyframeId keyframe) const {
  const auto room = rooms.find(keyframe);
  return room == rooms.end() || room->second.empty() ? "" : room->second.front().room;
}

std::string ThingPlaces::room_of(const pipeline::HomeThing& thing) const {
  const home::Keyframe& keyframe = keyframes.at(thing.keyframe_id);
  std::optional<Eigen::Vector3d> middle;
  if (layout && keyframe.pose.component == 0) {
    middle = layout->frame.on_plan(thing.box_world(keyframe.pose.world_from_keyframe).center());
  }
  return pipeline::room_of_thing(middle, keyframe.id, layout ? &layout->layout : nullptr,
                                 named_rooms, thing.room)
      .value_or(room_of(keyframe.id));
}

}  // namespace roomwise::app
