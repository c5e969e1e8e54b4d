#include "roomwise/mapping/frame_poses.h"

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

double seconds(TimestampNs from, TimestampNs to) {
  return static_cast<double>(to - from) * kSecondsPerNs;
}

// By key-frame: how the next one was measured from it, if it was.
std::vector<std::optional<RigidTransform>> steps_to_next(std::size_t count,
                                                         std::span<const PoseGraphEdge> edges) {
  std::vector<std::optional<RigidTransform>> steps(count);
  for (const PoseGraphEdge& edge : edges) {
    if (edge.to == edge.from + 1 && !edge.is_loop && !steps[edge.from])
      steps[edge.from] = edge.from_from_to;
  }
  return steps;
}

}  // namespace

std::vector<std::optional<RigidTransform>> frame_poses(
    std::span<const MappedFrame> frames, std::span<const RigidTransform> world_from_keyframe,
    std::span<const TimestampNs> keyframe_times, std::span<const PoseGraphEdge> edges) {
  const auto steps = steps_to_next(world_from_keyframe.size(), edges);
  std::vector<std::optional<RigidTransform>> poses;
  for (const MappedFrame& frame : frames) {
    auto& pose = poses.emplace_back();
    if (!frame.place) continue;
    const KeyframeId id = frame.place->keyframe;
    pose = world_from_keyframe[id] * frame.place->keyframe_from_camera;
    if (!steps[id] || frame.timestamp_ns <= keyframe_times[id] ||
        frame.timestamp_ns >= keyframe_times[id + 1]) {
      continue;
    }
    const RigidTransform correction =
        (world_from_keyframe[id] * *steps[id]).inverse() * world_from_keyframe[id + 1];
    const double share = seconds(keyframe_times[id], frame.timestamp_ns) /
                         seconds(keyframe_times[id], keyframe_times[id + 1]);
    pose = *pose * part_of(correction, share);
  }
  return poses;
}

std::vector<Vector6d> keyframe_motions(
    std::span<const MappedFrame> frames,
    std::span<const std::optional<RigidTransform>> world_from_frame,
    std::span<const TimestampNs> keyframe_times) {
  // Within this time a hand's motion is nearly steady.
  constexpr double kMost_s = 0.11;
  std::map<TimestampNs, std::size_t> frame_at;
  for (std::size_t i = 0; i < frames.size(); ++i) frame_at[frames[i].timestamp_ns] = i;
  std::vector<Vector6d> motions;
  for (const TimestampNs time : keyframe_times) {
    Vector6d& motion = motions.emplace_back(Vector6d::Zero());
    const auto found = frame_at.find(time);
    if (found == frame_at.end() || !world_from_frame[found->second]) continue;
    std::size_t before = found->second;
    std::size_t after = before;
    if (before > 0 && world_from_frame[before - 1]) --before;
    if (after + 1 < frames.size() && world_from_frame[after + 1]) ++after;
    const double duration_s = seconds(frames[before].timestamp_ns, frames[after].timestamp_ns);
    if (!(duration_s > 0) || duration_s > kMost_s) continue;
    const RigidTransform step = world_from_frame[before]->inverse() * *world_from_frame[after];
    const Eigen::AngleAxisd turn(step.rotation);
    motion << turn.angle() * turn.axis(), step.translation;
    motion /= duration_s;
  }
  return motions;
}

}  // namespace roomwise::mapping
