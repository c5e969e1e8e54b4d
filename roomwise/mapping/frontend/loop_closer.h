#pragma once

#include <functional>
#include <span>
#include <vector>

#include "roomwise/mapping/frontend/keyframe.h"
#include "roomwise/mapping/graph/pose_graph.h"
#include "roomwise/motion/frame_locator.h"

namespace roomwise::mapping {

struct LoopOptions {
  int neighbors = 3;      // key-frames just before the last one that are tried, always
  int random = 2;         // further key-frames drawn at random
  int similar = 3;        // further key-frames that look most like it, by an index
  int hit_neighbors = 2;  // neighbours on either side of a random hit that are tried after it
  // A key-frame's chance to be drawn falls with its place in time: the first is this many times as
  // likely as the newest. Earlier ones are preferred, since they take away more drift.
  double age_preference = 4.0;
  int min_inliers = 30;  // a loop must be surer than a step of the odometry
  double min_inlier_ratio = 0.25;

  [[nodiscard]] Expected<void> validate() const;
};

// Drawn at random with a preference for earlier ones, which take away more drift: the further
// key-frames that a new one is compared with when there are so many, itself included. Neither the
// last nor the neighbours before it are among them.
[[nodiscard]] std::vector<KeyframeId> sample_loop_candidates(std::size_t keyframe_count,
                                                             const LoopOptions& options,
                                                             RandomStream random);

// Where the newest key-frame is relative to an earlier one, or why that is not known.
using CompareKeyframes = std::function<Expected<motion::MotionOutcome>(KeyframeId reference)>;

// Edges from earlier key-frames to the newest, after the paper: one for every neighbour (those of
// the walk before the last key-frame, which is left to the odometry) and every `similar` one that
// matches; then some are drawn at random, and where one matches, the key-frames around it are
// explored and the one from which the camera moved least is taken. The result depends on `seed`,
// the key-frames and nothing else. Fails where a comparison does.
[[nodiscard]] Expected<std::vector<PoseGraphEdge>> close_loops(
    const KeyframeStamp& newest, const LoopOptions& options, std::span<const KeyframeId> neighbors,
    std::span<const KeyframeId> similar, const CompareKeyframes& compare, std::uint64_t seed);

// Whether the edge is a return to a place that was left, and not one between neighbours on the
// walk: its key-frames are more than ten apart.
[[nodiscard]] bool spans_long_loop(const PoseGraphEdge& edge);

// The edge between two key-frames from the motion that was found between them.
[[nodiscard]] PoseGraphEdge edge_from_motion(KeyframeId from, KeyframeId to,
                                             const motion::RefinedPose& pose, bool is_robust);

// The edge between two key-frames from one frame that was located against both: a loop, since that
// a place was known again may be wrong.
[[nodiscard]] PoseGraphEdge edge_through_frame(KeyframeId from, const motion::RefinedPose& in_from,
                                               KeyframeId to, const motion::RefinedPose& in_to);

}  // namespace roomwise::mapping
