#include "roomwise/pipeline/rooms/home_layout.h"

#include <map>

namespace roomwise::pipeline {
namespace {

// Where the camera was over the floor at each frame that the largest component of the map places.
Expected<rooms::WalkedPath> walked_path(
    const home::Home& home, home::RecordingId recording, const fusion::GravityAlignedFrame& frame,
    const std::map<home::KeyframeId, home::KeyframePose>& poses) {
  ROOMWISE_TRY(const recording::RoomLabels labels, home.room_ranges(recording));
  ROOMWISE_TRY(const auto frames, home.frames(recording));
  rooms::WalkedPath path;
  for (const home::Frame& one : frames) {
    if (!one.place) continue;
    const auto pose = poses.find(one.place->keyframe);
    if (pose == poses.end() || pose->second.component != 0) continue;
    const Eigen::Vector3d camera_gravity =
        frame.gravity_from_world *
        (pose->second.world_from_keyframe * one.place->keyframe_from_camera.translation);
    const recording::RoomRange* const range = labels.find(one.index);
    path.push_back({camera_gravity.head<2>(), range != nullptr ? range->room : std::string()});
  }
  return path;
}

Expected<void> check_rooms_are_named(const home::Home& home) {
  ROOMWISE_TRY(const auto rooms, home.rooms());
  if (!rooms.empty()) return {};
  return fail("{}: no rooms are named; name them with roomwise rooms name", home.file());
}

}  // namespace

Expected<std::optional<rooms::RoomLayout>> find_room_layout(
    const home::Home& home, const fusion::GravityAlignedFrame& frame, const fusion::FloorGrid& grid,
    const rooms::RoomLayoutOptions& options) {
  std::map<home::KeyframeId, home::KeyframePose> poses;
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  for (const home::Keyframe& keyframe : keyframes) poses[keyframe.id] = keyframe.pose;
  ROOMWISE_TRY(const auto recordings, home.recordings());
  std::vector<rooms::WalkedPath> walks;
  for (const home::StoredRecording& recording : recordings) {
    ROOMWISE_TRY(walks.emplace_back(), walked_path(home, recording.id, frame, poses));
  }
  ROOMWISE_TRY(rooms::RoomLayout layout, rooms::RoomLayout::make(grid, walks, options));
  if (!layout.has_floor()) return std::nullopt;
  return layout;
}

Expected<HomeLayout> build_home_layout(const home::Home& home,
                                       const rooms::RoomLayoutOptions& options, RunContext& run) {
  ROOMWISE_CHECK_OK(options.validate());
  ROOMWISE_CHECK_OK(check_rooms_are_named(home));
  ROOMWISE_TRY(HomeFloor floor, find_home_floor(home, run));
  if (!floor.grid) {
    return fail("{}: the map shows no floor; walk with the camera tilted down a little",
                home.file());
  }
  ROOMWISE_TRY(auto layout, find_room_layout(home, floor.frame, *floor.grid, options));
  if (!layout) {
    return fail(
        "{}: no named place of the walk lies on free floor; name the rooms of the walk, or walk "
        "with the camera tilted down a little",
        home.file());
  }
  return HomeLayout{floor.frame, *std::move(floor.grid), *std::move(layout)};
}

Expected<std::optional<HomeLayout>> find_home_layout(const home::Home& home, RunContext& run) {
  std::optional<HomeLayout> none;
  ROOMWISE_TRY(const auto rooms, home.rooms());
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  if (rooms.empty() || keyframes.empty()) return none;
  ROOMWISE_TRY(HomeFloor floor, find_home_floor(home, run));
  if (!floor.grid) return none;
  ROOMWISE_TRY(auto layout, find_room_layout(home, floor.frame, *floor.grid));
  if (!layout) return none;
  return HomeLayout{floor.frame, *std::move(floor.grid), *std::move(layout)};
}

}  // namespace roomwise::pipeline
