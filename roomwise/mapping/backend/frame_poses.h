#pragma once

#include <optional>
#include <span>
#include <vector>

#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/mapping/frontend/mapper.h"
#include "roomwise/mapping/graph/pose_graph.h"

namespace roomwise::mapping {

// Within this time a hand's motion is nearly steady, or is sped up steadily.
inline constexpr double kConstantVelocity_s = 0.11;

// Key-frames of a solved map, by id.
struct SolvedKeyframes {
  std::span<const geometry::RigidTransform> world_from_keyframe;
  std::span<const TimestampNs> timestamps_ns;
  std::span<const std::size_t> component;  // each has a world of its own
};

// Where frames are, once their key-frames have been moved. A frame between two key-frames was
// measured from the first, as the second was: what the solved poses say otherwise of the second
// grows from one to the other in the course of time. Nothing for frames without a place.
// `edges` are those that agree with the solution, frames in the order of time.
[[nodiscard]] std::vector<std::optional<geometry::RigidTransform>> frame_poses(
    std::span<const Frame> frames, const SolvedKeyframes& keyframes,
    std::span<const PoseGraphEdge> edges);

// How each key-frame's camera moved while it took its picture: a twist in its own frame (rad/s,
// m/s) from the poses of the frames before and after. Zero where frames of its component are too
// far apart in time to tell.
[[nodiscard]] std::vector<geometry::Vector6d> keyframe_velocities(
    std::span<const Frame> frames,
    std::span<const std::optional<geometry::RigidTransform>> world_from_frame,
    const SolvedKeyframes& keyframes);

// How each key-frame's camera turned, in its own frame, rad/s: on average from the frame before to
// the frame after, however far apart these are. Nothing where its component has no frame beside it.
[[nodiscard]] std::vector<std::optional<Eigen::Vector3d>> keyframe_turning(
    std::span<const Frame> frames,
    std::span<const std::optional<geometry::RigidTransform>> world_from_frame,
    const SolvedKeyframes& keyframes);

}  // namespace roomwise::mapping
