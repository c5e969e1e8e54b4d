#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/mapping/frontend/keyframe.h"

namespace roomwise::mapping {

// A part of a map that is adjusted while the rest is held. Ids ascend.
struct RefinementWindow {
  std::vector<KeyframeId> own;     // are moved; in one window each
  std::vector<KeyframeId> around;  // may show the same as some of these
};

// Divides a map into windows of at most `max_own` key-frames each, which grow from the earliest
// over those that may show the same (may_be_covisible()), so that few landmarks lie on a border.
// Around a window are at most `max_around`, those that may show the same as most of its own, of
// equals the earlier. Those of different groups (components of the map) show nothing of each other.
// Key-frames are looked for in cells of space: what a window costs does not grow with the map.
[[nodiscard]] std::vector<RefinementWindow> refinement_windows(
    std::span<const geometry::RigidTransform> world_from_keyframe,
    std::span<const std::size_t> groups, std::size_t max_own, std::size_t max_around);

}  // namespace roomwise::mapping
