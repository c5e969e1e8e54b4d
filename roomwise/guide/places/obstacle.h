#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/fusion/floor_grid.h"
#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/guide/places/places.h"
#include "roomwise/guide/words/wording.h"
#include "roomwise/image/image.h"

namespace roomwise::guide {

// Where a depth camera looks for what a person could walk into, and how it is held.
struct ObstacleOptions {
  double lowest_m = 0.15;  // above the floor; lower things are left to the cane
  double highest_m = 1.9;
  double nearest_m = 0.3;   // what is nearer is a hand, or the camera measures nothing
  double farthest_m = 2.0;  // along the floor
  double beside_m = 1.0;    // to each side
  // As much surface must be seen within a square of 0.3 m of floor: single wrong pixels are no
  // obstacle.
  double min_area_m2 = 0.01;

  double camera_height_m = 1.3;
  Eigen::Vector3d up_camera = -Eigen::Vector3d::UnitY();  // unit length; a level camera's

  [[nodiscard]] Expected<void> validate() const;
};

// Where on the floor something stands or hangs: m ahead of the camera and m to its left, one place
// for each square of 0.1 m in which surface is seen. None where the camera looks so steeply up or
// down that it does not see ahead. It knows only what the depth camera measures: glass, mirrors and
// things nearer than half a metre are mostly missing, so none does not mean that the way is free.
// Fails where the image does not fit the camera.
[[nodiscard]] Expected<std::vector<Eigen::Vector2d>> obstacles_seen(
    const image::DepthImage& depth, const geometry::PinholeCamera& camera,
    const ObstacleOptions& options = {});

// The space that somebody walks into next who goes where they face.
struct WalkingCorridor {
  double half_width_m = 0.3;
  double length_m = 1.0;  // one or two steps
};

// What stands in a corridor: where its nearest place is, on which side all of it stands, and all
// places.
struct ObstacleAhead {
  enum class Side { kAhead, kLeft, kRight };  // kAhead: in the middle, or on both sides
  Eigen::Vector2d ahead_left_m = Eigen::Vector2d::Zero();
  Side side = Side::kAhead;
  std::vector<Eigen::Vector2d> all = {};  // m ahead and to the left
};
// A side where none of them is nearer to the middle than a square.
[[nodiscard]] ObstacleAhead::Side side_of(std::span<const Eigen::Vector2d> ahead_left_m);
// The nearest of them in the corridor; nothing where none stands there.
[[nodiscard]] std::optional<ObstacleAhead> nearest_ahead(std::span<const Eigen::Vector2d> obstacles,
                                                         const WalkingCorridor& corridor = {});

// Whether the map knows what was seen there: it is no farther from all that is occupied than places
// and maps err.
[[nodiscard]] bool is_on_map(const Eigen::Vector2d& obstacle, const fusion::FloorGrid& floor);

// "guide.stop_" and a thing that stands to the left: "guide.stop_thing_left", filled with the
// thing; without one "guide.stop_obstacle_left".
[[nodiscard]] Phrase obstacle_phrase(const std::string& begin, ObstacleAhead::Side side,
                                     const KnownThing* thing);
// "Obstacle ahead, to the left.", or what the map has there: "Table ahead, to the left."
[[nodiscard]] Prompt hazard_prompt(const ObstacleAhead& obstacle, const KnownThing* thing,
                                   const Wording& wording, TimestampNs now_ns);

}  // namespace roomwise::guide
