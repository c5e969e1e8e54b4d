#pragma once

#include <span>
#include <vector>

#include "roomwise/mapping/backend/map_solver.h"

namespace roomwise::mapping {

// Two walks are joined only where several edges between them say the same of where one lies in the
// other: one alone may come of two things that look alike, and nothing would contradict it.
struct WalkJoinOptions {
  std::size_t min_agreeing = 3;  // edges, from two or more key-frames of each walk
  // Edges agree whose worlds differ by no more than this and, for what the walks have drifted
  // between them, by this part of the way from one to the other.
  double max_distance_m = 0.2;
  double max_drift = 0.02;
  double max_angle_rad = 0.08;

  [[nodiscard]] Expected<void> validate() const;
};

// The edges without those between key-frames of different parts of the map that too few others
// agree with. `part_of` says of each key-frame in which part it is: those of a part were joined
// before, or are of one walk; all edges must be between such key-frames.
[[nodiscard]] Expected<std::vector<PoseGraphEdge>> without_unsupported_joins(
    std::span<const std::size_t> part_of, std::span<const PoseGraphEdge> edges,
    const MapSolverOptions& solver = {}, const WalkJoinOptions& options = {});

}  // namespace roomwise::mapping
