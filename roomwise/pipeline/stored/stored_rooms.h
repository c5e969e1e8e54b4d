#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>

#include "roomwise/fusion/gravity_aligned_frame.h"
#include "roomwise/home/home.h"
#include "roomwise/rooms/layout/room_layout.h"

// In which rooms a home's key-frames were taken, and its things stand.
namespace roomwise::pipeline {

using KeyframeRooms = std::map<home::KeyframeId, std::string>;

// The room of each key-frame, as the helper named the frames of its walk. Those that nobody named
// are left out.
[[nodiscard]] Expected<KeyframeRooms> rooms_of_keyframes(const home::Home& home);

// Where the middle of a thing's box lies on the map, m. Nothing where its key-frame, whose pose is
// given, lies in another component of the map.
[[nodiscard]] std::optional<Eigen::Vector3d> middle_on_map(
    const objects::Instance& thing, const home::KeyframePose& pose,
    const fusion::GravityAlignedFrame& frame);

// The room that a thing stands in: that on whose floor its middle lies, where it is known where the
// rooms lie; else that in which the key-frame was taken that shows it best. Nothing where neither
// tells. `middle_plan`: m; absent where the thing has no place on the map. `layout`: nullptr
// where it is not known where the rooms lie. `put_in`: the room that somebody put it in by hand,
// where its floor does not tell.
[[nodiscard]] std::optional<std::string> room_of_thing(
    const std::optional<Eigen::Vector3d>& middle_plan, home::KeyframeId shows_best,
    const rooms::RoomLayout* layout, const KeyframeRooms& keyframe_rooms,
    const std::optional<std::string>& put_in = std::nullopt);

}  // namespace roomwise::pipeline
