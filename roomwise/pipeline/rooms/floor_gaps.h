#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "roomwise/pipeline/rooms/home_layout.h"

// Where the walks of a home have not shown its floor.
namespace roomwise::pipeline {

// Where the floor of a room goes on and nothing was seen of it, or floor that was only seen from
// afar.
struct FloorGap {
  std::string room;
  bool is_unseen = false;  // else it was seen from afar
  // Of what is unseen the length of the edge to the floor that was seen: how far it goes on is not
  // known. Of the rest its own. From end to end, m.
  double length_m = 0;
  Eigen::Vector2d middle_plan = Eigen::Vector2d::Zero();  // of the edge, or of the floor, m
  std::string beside;  // the thing that stands nearest, within 1.5 m; empty: none
};

struct FloorGapOptions {
  // Farther things are not measured well enough to be found (objects::InstanceOptions).
  double near_m = 4.5;
  double min_gap_m = 0.5;  // what is narrower or shorter is no place for a person to stand

  [[nodiscard]] Expected<void> validate() const;
};

// The longest first. `keyframes` and `things`: all of the home; those of other components of the
// map count for nothing.
[[nodiscard]] Expected<std::vector<FloorGap>> find_floor_gaps(
    const home::Home& home, const HomeLayout& layout, std::span<const home::Keyframe> keyframes,
    const FloorGapOptions& options);

}  // namespace roomwise::pipeline
