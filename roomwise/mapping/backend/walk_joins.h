#pragma once

#include <functional>
#include <span>
#include <vector>

#include "roomwise/mapping/backend/map_solver.h"
#include "roomwise/motion/view_agreement.h"

namespace roomwise::mapping {

// Two walks are joined only where several edges between them say the same of where one lies in the
// other: one alone may come of two things that look alike, and nothing would contradict it.
struct WalkJoinOptions {
  std::size_t min_agreeing_edges = 3;  // from two or more key-frames of each walk
  // Edges agree whose worlds differ by no more than this and, for what the walks have drifted
  // between them, by this part of the way from one to the other.
  double max_distance_m = 0.2;
  double max_drift = 0.02;
  double max_angle_rad = 0.08;
  // What joined parts measured of the same place must be the same, or one thing that both homes
  // have, a bookcase of one make, would join them. Compared are at most so many key-frames of the
  // smaller part, each with the nearest of the other; what may show the same, and how much of it
  // must agree, is as the localiser takes it.
  std::size_t max_compared = 64;
  std::size_t max_nearest = 6;
  double place_m = 1.2;
  double place_rad = 0.8;
  double min_overlap = 0.2;
  double min_agreeing = 0.6;
  double max_seen_through = 0.2;

  [[nodiscard]] Expected<void> validate() const;
};

// The edges without those between key-frames of different parts of the map that too few others
// agree with. `part_of` says of each key-frame in which part it is: those of a part were joined
// before, or are of one walk; all edges must be between such key-frames.
[[nodiscard]] Expected<std::vector<PoseGraphEdge>> without_unsupported_joins(
    std::span<const std::size_t> part_of, std::span<const PoseGraphEdge> edges,
    const MapSolverOptions& solver = {}, const WalkJoinOptions& options = {});

// How well the depths that two key-frames measured agree at a pose; what cannot be read overlaps
// with nothing, and says nothing.
using CompareDepths =
    std::function<motion::ViewAgreement(KeyframeId reference, KeyframeId current,
                                        const geometry::RigidTransform& reference_from_current)>;

// The edges without those that join two parts of which, where `solution` puts them, the key-frames
// say that they are different places. Of several such pairs only the one that agrees least goes: in
// a ring of parts a wrong join bends the right ones, which must be judged anew without it, until
// all stay. All edges must be those of the solution.
[[nodiscard]] Expected<std::vector<PoseGraphEdge>> without_contradicted_joins(
    std::span<const std::size_t> part_of, std::span<const PoseGraphEdge> edges,
    const MapSolution& solution, const CompareDepths& compare, const WalkJoinOptions& options = {});

}  // namespace roomwise::mapping
