#include "roomwise/mapping/backend/frame_poses.h"

#include <algorithm>
#include <map>

namespace roomwise::mapping {
namespace {

using geometry::RigidTransform;
using geometry::Vector6d;

// A small motion's part.
RigidTransform part_of(const RigidTransform& motion, double share) {
  return {Eigen::Quaterniond::Identity().slerp(share, motion.rotation), share * motion.translation};
}

// By key-frame: how the next one was measured from it, if it was and lies in the same component.
std::vector<std::optional<RigidTransform>> steps_to_next(std::span<const std::size_t> component,
                                                         std::span<const PoseGraphEdge> edges) {
  std::vector<std::optional<RigidTransform>> steps(component.size());
  for (const PoseGraphEdge& edge : edges) {
    const bool is_step = !edge.is_robust || edge.is_device_motion;
    if (edge.to == edge.from + 1 && is_step && component[edge.from] == component[edge.to] &&
        !steps[edge.from]) {
      steps[edge.from] = edge.from_from_to;
    }
  }
  return steps;
}

// How a camera moved on average from the frame before to the frame after: a twist in its own frame
// (rad/s, m/s).
struct MeanMotion {
  Vector6d twist;
  double duration_s = 0;
};

// By key-frame; nothing where its component has no frame beside it.
std::vector<std::optional<MeanMotion>> mean_motions(
    std::span<const Frame> frames, std::span<const std::optional<RigidTransform>> world_from_frame,
    const SolvedKeyframes& keyframes) {
  std::map<TimestampNs, std::size_t> frame_at;
  for (std::size_t i = 0; i < frames.size(); ++i) frame_at[frames[i].timestamp_ns] = i;
  const auto is_of_component = [&](std::size_t i, std::size_t component) {
    return world_from_frame[i] && frames[i].place &&
           keyframes.component[frames[i].place->keyframe] == component;
  };
  std::vector<std::optional<MeanMotion>> motions;
  for (std::size_t id = 0; id < keyframes.timestamps_ns.size(); ++id) {
    const std::size_t component = keyframes.component[id];
    std::optional<MeanMotion>& motion = motions.emplace_back();
    const auto found = frame_at.find(keyframes.timestamps_ns[id]);
    if (found == frame_at.end() || !is_of_component(found->second, component)) continue;
    std::size_t before = found->second;
    std::size_t after = before;
    if (before > 0 && is_of_component(before - 1, component)) --before;
    if (after + 1 < frames.size() && is_of_component(after + 1, component)) ++after;
    const double duration_s =
        seconds_between(frames[before].timestamp_ns, frames[after].timestamp_ns);
    if (!(duration_s > 0)) continue;
    const RigidTransform step = world_from_frame[before]->inverse() * *world_from_frame[after];
    const Eigen::AngleAxisd turn(step.rotation);
    motion = {Vector6d::Zero(), duration_s};
    motion->twist << turn.angle() * turn.axis(), step.translation;
    motion->twist /= duration_s;
  }
  return motions;
}

}  // namespace

std::vector<std::optional<RigidTransform>> frame_poses(std::span<const Frame> frames,
                                                       const SolvedKeyframes& keyframes,
                                                       std::span<const PoseGraphEdge> edges) {
  const auto& [world_from_keyframe, times_ns, component] = keyframes;
  const auto steps = steps_to_next(component, edges);
  std::vector<std::optional<RigidTransform>> poses;
  for (const Frame& frame : frames) {
    auto& pose = poses.emplace_back();
    if (!frame.place) continue;
    const KeyframeId id = frame.place->keyframe;
    pose = world_from_keyframe[id] * frame.place->keyframe_from_camera;
    if (!steps[id] || frame.timestamp_ns <= times_ns[id] ||
        frame.timestamp_ns >= times_ns[id + 1]) {
      continue;
    }
    const RigidTransform correction =
        (world_from_keyframe[id] * *steps[id]).inverse() * world_from_keyframe[id + 1];
    const double share = seconds_between(times_ns[id], frame.timestamp_ns) /
                         seconds_between(times_ns[id], times_ns[id + 1]);
    pose = *pose * part_of(correction, share);
  }
  return poses;
}

std::vector<Vector6d> keyframe_velocities(
    std::span<const Frame> frames, std::span<const std::optional<RigidTransform>> world_from_frame,
    const SolvedKeyframes& keyframes) {
  std::vector<Vector6d> velocities;
  for (const auto& motion : mean_motions(frames, world_from_frame, keyframes)) {
    const bool is_known = motion && motion->duration_s <= kConstantVelocity_s;
    velocities.push_back(is_known ? motion->twist : Vector6d::Zero());
  }
  return velocities;
}

std::vector<std::optional<Eigen::Vector3d>> keyframe_turning(
    std::span<const Frame> frames, std::span<const std::optional<RigidTransform>> world_from_frame,
    const SolvedKeyframes& keyframes) {
  std::vector<std::optional<Eigen::Vector3d>> turning;
  for (const auto& motion : mean_motions(frames, world_from_frame, keyframes)) {
    turning.emplace_back();
    if (motion) turning.back() = motion->twist.head<3>();
  }
  return turning;
}

}  // namespace roomwise::mapping
