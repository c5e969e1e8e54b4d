#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "roomwise/fusion/gravity_aligned_frame.h"
#include "roomwise/pipeline/edits/edit_things.h"
#include "roomwise/rooms/layout/room_layout.h"

namespace roomwise::pipeline {

// Where somebody says that a thing is, as people do.
struct SaidPlace {
  std::optional<Eigen::Vector2d> point_plan = std::nullopt;  // on the floor, m
  std::optional<double> height_m = std::nullopt;             // of its middle, above the floor
  std::string room = {};  // in this room; where there is no point
};

// The point, or the middle of the room: where its floor is widest or, where the map does not show
// that, where somebody stood in it. Without a height the thing stands as high as before or, new, on
// the floor where such things do, else on a table of 0.75 m. `layout`: nullptr where it is not
// known where rooms lie; `before`: nullptr of a new thing. Fails where neither tells a place, and
// where it lies far outside the map (map_extent.h).
[[nodiscard]] Expected<ThingTarget> target_of(const home::Home& home,
                                              const fusion::GravityAlignedFrame& frame,
                                              const rooms::RoomLayout* layout,
                                              const SaidPlace& where, const std::string& name,
                                              const HomeThing* before);

}  // namespace roomwise::pipeline
