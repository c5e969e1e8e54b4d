#pragma once

#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/motion/small_view.h"

namespace roomwise::motion {

// How well two views agree at a pose. Shares are of the reference's measured pixels that fall into
// the current image where it measured depth.
struct ViewAgreement {
  double overlap = 0;       // of all measured pixels of the reference, how many those are
  double agreeing = 0;      // both depths are the same surface
  double seen_through = 0;  // the current view looks through the reference's surface
  double in_front = 0;      // the current view has something before it: hidden, or a wrong pose
};

// Compares the depths of the second level. An empty view has nothing in common with any.
[[nodiscard]] ViewAgreement compare_views(const SmallView& reference, const SmallView& current,
                                          const geometry::RigidTransform& reference_from_current);

}  // namespace roomwise::motion
