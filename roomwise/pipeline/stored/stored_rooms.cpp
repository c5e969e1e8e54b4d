#include "roomwise/pipeline/stored/stored_rooms.h"

namespace roomwise::pipeline {

Expected<KeyframeRooms> rooms_of_keyframes(const home::Home& home) {
  KeyframeRooms rooms;
  std::map<home::RecordingId, recording::RoomLabels> labels;
  ROOMWISE_TRY(const auto recordings, home.recordings());
  for (const home::StoredRecording& one : recordings) {
    ROOMWISE_TRY(labels[one.id], home.room_ranges(one.id));
  }
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  for (const home::Keyframe& keyframe : keyframes) {
    const recording::RoomRange* const range =
        labels.at(keyframe.recording).find(keyframe.frame_index);
    if (range != nullptr) rooms[keyframe.id] = range->room;
  }
  return rooms;
}

std::optional<Eigen::Vector3d> middle_on_map(const objects::Instance& thing,
                                             const home::KeyframePose& pose,
                                             const fusion::GravityAlignedFrame& frame) {
  if (pose.component != 0) return std::nullopt;
  return frame.on_plan(thing.box_world(pose.world_from_keyframe).center());
}

std::optional<std::string> room_of_thing(const std::optional<Eigen::Vector3d>& middle_plan,
                                         home::KeyframeId shows_best,
                                         const rooms::RoomLayout* layout,
                                         const KeyframeRooms& keyframe_rooms,
                                         const std::optional<std::string>& put_in) {
  if (layout && middle_plan) {
    if (auto room = layout->room_at(middle_plan->head<2>())) return room;
  }
  if (put_in) return put_in;
  const auto shows = keyframe_rooms.find(shows_best);
  return shows == keyframe_rooms.end() ? std::nullopt : std::optional(shows->second);
}

}  // namespace roomwise::pipeline
