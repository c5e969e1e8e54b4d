#pragma once

#include <span>

#include "roomwise/fusion/floor_grid.h"
#include "roomwise/fusion/gravity_aligned_frame.h"
#include "roomwise/pipeline/stored/keyframe_images.h"

namespace roomwise::pipeline {

// The same floor, free also where a walk led and the floor itself was not seen: a camera looks
// ahead, and what lies close behind a door is walked over before it is looked at. What was seen to
// be occupied stays so. Frames tell of it, since key-frames give way to those that show the same.
// `frames`: see walked_frames().
//
// A step up or down is no floor, also where no stairs were recognised: only what the walk crossed
// at the height at which its camera is mostly held on that storey, and went on level for as far as
// a camera may be ahead of the feet. Who holds the camera over a banister and walks along it, or
// draws it back, cannot be told from who walks there: where nothing was seen, that counts as
// walked.
[[nodiscard]] fusion::FloorGrid with_walked_ways(const fusion::FloorGrid& floor,
                                                 const fusion::GravityAlignedFrame& frame,
                                                 std::span<const WalkedFrame> frames);

}  // namespace roomwise::pipeline
