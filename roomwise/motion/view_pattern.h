#pragma once

#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/motion/rgbd_pyramid.h"

namespace roomwise::motion {

// The pattern on the surfaces of a view: edges and what is painted on them, as if the light were
// the same everywhere. Each pixel's brightness less the mean of those around it, over their
// contrast, about 128; what differs by less than noise stays plain. By lamp light it looks much as
// by day, and on a wall without any features it still shows where the door is.
struct ViewPattern {
  image::GrayImage even;  // of the view's second level; empty for an empty view

  [[nodiscard]] static ViewPattern of(const RgbdPyramid& view);
};

// How much two views' patterns are alike where both see the same surface; several pairs of views
// can be added up.
struct PatternCorrelation {
  double products = 0;
  double reference_squares = 0;
  double current_squares = 0;
  double pixels = 0;

  // The correlation, -1 to 1, a little less for noise: a faint pattern is like no other. 0 where
  // nothing was compared.
  [[nodiscard]] double value() const;
  PatternCorrelation& operator+=(const PatternCorrelation& other);
};

// Compares the patterns at a pose, each with the view of which it was made.
[[nodiscard]] PatternCorrelation compare_patterns(
    const RgbdPyramid& reference_view, const ViewPattern& reference_pattern,
    const RgbdPyramid& current_view, const ViewPattern& current_pattern,
    const geometry::RigidTransform& reference_from_current);

}  // namespace roomwise::motion
