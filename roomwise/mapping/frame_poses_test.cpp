#include "roomwise/mapping/frame_poses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace roomwise::mapping {
namespace {

using geometry::Matrix6d;
using geometry::RigidTransform;
using geometry::Vector6d;

constexpr TimestampNs kFrame_ns = 30'000'000;

RigidTransform along(double x_m) {
  return {Eigen::Quaterniond::Identity(), {x_m, 0, 0}};
}
MappedFrame frame(int index, KeyframeId keyframe, const RigidTransform& place) {
  return {static_cast<std::uint64_t>(index), index * kFrame_ns, FramePlace{keyframe, place}, {}};
}

// Two key-frames, frames 0 and 4, and three between them that go on at 0.1 m a frame.
struct Walk {
  std::vector<MappedFrame> frames{frame(0, 0, along(0)), frame(1, 0, along(0.1)),
                                  frame(2, 0, along(0.2)), frame(3, 0, along(0.3)),
                                  frame(4, 1, along(0))};
  std::vector<TimestampNs> times{0, 4 * kFrame_ns};
  std::vector<PoseGraphEdge> edges{{0, 1, along(0.4), Matrix6d::Identity(), false}};
};

TEST(FramePoses, AreAsMeasuredWhereTheKeyframesAre) {
  const Walk walk;
  const auto poses =
      frame_poses(walk.frames, std::vector{along(1), along(1.4)}, walk.times, walk.edges);
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_NEAR(poses[i]->translation.x(), 1 + 0.1 * static_cast<double>(i), 1e-12);
}

TEST(FramePoses, FollowBothKeyframesInTheCourseOfTime) {
  Walk walk;
  const std::vector<RigidTransform> solved{
      along(0),
      {Eigen::Quaterniond(Eigen::AngleAxisd(0.04, Eigen::Vector3d::UnitZ())), {0.4, 0.02, 0}}};
  const auto poses = frame_poses(walk.frames, solved, walk.times, walk.edges);
  for (std::size_t i = 0; i < 5; ++i) {
    const double share = static_cast<double>(i) / 4;
    EXPECT_NEAR(poses[i]->translation.y(), 0.02 * share, 1e-12);
    EXPECT_NEAR(poses[i]->angle_rad(), 0.04 * share, 1e-9);
  }
  // Without a step between the two nothing says so.
  walk.edges[0].is_loop = true;
  EXPECT_EQ(frame_poses(walk.frames, solved, walk.times, walk.edges)[2]->translation.y(), 0);
}

TEST(FramePoses, LeaveFramesWithoutAPlaceOut) {
  Walk walk;
  walk.frames[2].place.reset();
  const auto poses =
      frame_poses(walk.frames, std::vector{along(0), along(0.4)}, walk.times, walk.edges);
  EXPECT_FALSE(poses[2].has_value());
  EXPECT_TRUE(poses[3].has_value());
}

TEST(KeyframeMotions, AreThoseBetweenTheFramesAround) {
  Vector6d motion;
  motion << 0.5, -1, 0.2, 0.3, 0.1, -0.4;  // rad/s, m/s
  std::vector<MappedFrame> frames;
  std::vector<std::optional<RigidTransform>> poses;
  for (int i = 0; i < 5; ++i) {
    frames.push_back(frame(i, 0, {}));
    poses.emplace_back(
        RigidTransform::exp(static_cast<double>(i) * kFrame_ns * kSecondsPerNs * motion));
  }
  const std::vector<TimestampNs> times{2 * kFrame_ns, 4 * kFrame_ns};
  const auto motions = keyframe_motions(frames, poses, times);
  for (const Vector6d& found : motions) EXPECT_LT((found - motion).norm(), 0.03);

  // Three frames a second tell no motion, nor does a frame alone.
  for (MappedFrame& each : frames) each.timestamp_ns *= 10;
  EXPECT_EQ(keyframe_motions(frames, poses, std::vector{20 * kFrame_ns})[0], Vector6d::Zero());
  EXPECT_EQ(keyframe_motions({}, {}, times)[0], Vector6d::Zero());
}

}  // namespace
}  // namespace roomwise::mapping
