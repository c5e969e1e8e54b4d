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

// The edges without those between key-frames of different walks that too few others agree with.
// `first_keyframes` are those of the walks, in their order, beginning with 0; all edges must be
// between key-frames below the count.
[[nodiscard]] Expected<std::vector<PoseGraphEdge>> without_unsupported_joins(
    std::size_t keyframe_count, std::span<const PoseGraphEdge> edges,
    std::span<const KeyframeId> first_keyframes, const MapSolverOptions& solver = {},
    const WalkJoinOptions& options = {});

}  // namespace roomwise::mapping
