#pragma once

#include <Eigen/Core>
#include <optional>

#include "roomwise/base/expected.h"
#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/guide/wording.h"
#include "roomwise/image/image.h"

namespace roomwise::guide {

// The space that somebody walks into next, and how their camera looks at it.
struct WalkingCorridor {
  double half_width_m = 0.3;
  double lowest_m = 0.15;  // above the floor; lower things are left to the cane
  double highest_m = 1.9;
  double nearest_m = 0.3;   // what is nearer is a hand, or the camera measures nothing
  double farthest_m = 1.0;  // one or two steps
  // As much surface must be seen within 10 cm of depth: single wrong pixels are no obstacle.
  double min_area_m2 = 0.01;

  double camera_height_m = 1.3;
  Eigen::Vector3d up_camera = -Eigen::Vector3d::UnitY();  // unit length; a level camera's

  [[nodiscard]] Expected<void> validate() const;
};

// How far it is to the nearest obstacle ahead, m along the floor; nothing where there is none, or
// where the camera looks so steeply up or down that it does not see ahead. It knows only what the
// depth camera measures: glass, mirrors and things nearer than half a metre are mostly missing, so
// nothing ahead does not mean that the way is free. Fails where the image does not fit the camera.
[[nodiscard]] Expected<std::optional<double>> obstacle_ahead_m(
    const image::DepthImage& depth, const geometry::PinholeCamera& camera,
    const WalkingCorridor& corridor = {});

// "Obstacle ahead."
[[nodiscard]] Prompt hazard_prompt(double distance_m, const Wording& wording, TimestampNs now_ns);

}  // namespace roomwise::guide
