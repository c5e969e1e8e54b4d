#pragma once

#include <span>

#include "roomwise/fusion/floor_grid.h"
#include "roomwise/fusion/gravity_aligned_frame.h"
#include "roomwise/home/home.h"

namespace roomwise::pipeline {

// The same floor, free also where a walk led and the floor itself was not seen: a camera looks
// ahead, and what lies close behind a door is walked over before it is looked at. What was seen to
// be occupied stays so. `keyframes`: of the map, by id.
[[nodiscard]] fusion::FloorGrid with_walked_ways(const fusion::FloorGrid& floor,
                                                 const fusion::GravityAlignedFrame& frame,
                                                 std::span<const home::Keyframe> keyframes);

}  // namespace roomwise::pipeline
