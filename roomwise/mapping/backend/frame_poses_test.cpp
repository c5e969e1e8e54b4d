#include "roomwise/mapping/backend/frame_poses.h"

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
Frame frame(int index, KeyframeId keyframe, const RigidTransform& place) {
  return {static_cast<std::uint64_t>(index), index * kFrame_ns, FramePlace{keyframe, place}, {}};
}

// Two key-frames, frames 0 and 4, and three between them that go on at 0.1 m a frame.
struct Walk {
  std::vector<Frame> frames{frame(0, 0, along(0)), frame(1, 0, along(0.1)), frame(2, 0, along(0.2)),
                            frame(3, 0, along(0.3)), frame(4, 1, along(0))};
  std::vector<TimestampNs> times{0, 4 * kFrame_ns};
  std::vector<std::size_t> component{0, 0};
  std::vector<PoseGraphEdge> edges{{0, 1, along(0.4), Matrix6d::Identity(), false}};

  [[nodiscard]] auto poses(const std::vector<RigidTransform>& solved) const {
    return frame_poses(frames, {solved, times, component}, edges);
  }
};

TEST(FramePoses, AreAsMeasuredWhereTheKeyframesAre) {
  const Walk walk;
  const auto poses = walk.poses({along(1), along(1.4)});
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_NEAR(poses[i]->translation.x(), 1 + 0.1 * static_cast<double>(i), 1e-12);
}

TEST(FramePoses, FollowBothKeyframesInTheCourseOfTime) {
  Walk walk;
  const std::vector<RigidTransform> solved{
      along(0),
      {Eigen::Quaterniond(Eigen::AngleAxisd(0.04, Eigen::Vector3d::UnitZ())), {0.4, 0.02, 0}}};
  const auto poses = walk.poses(solved);
  for (std::size_t i = 0; i < 5; ++i) {
    const double share = static_cast<double>(i) / 4;
    EXPECT_NEAR(poses[i]->translation.y(), 0.02 * share, 1e-12);
    EXPECT_NEAR(poses[i]->angle_rad(), 0.04 * share, 1e-9);
  }
  // Without a step between the two nothing says so.
  walk.edges[0].is_robust = true;
  EXPECT_EQ(walk.poses(solved)[2]->translation.y(), 0);
}

TEST(FramePoses, AreNotDrawnTowardsAnotherComponentsWorld) {
  Walk walk;
  walk.component = {0, 1};
  const auto poses = walk.poses({along(0), along(50)});
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_NEAR(poses[i]->translation.x(), 0.1 * static_cast<double>(i), 1e-12);
}

TEST(FramePoses, LeaveFramesWithoutAPlaceOut) {
  Walk walk;
  walk.frames[2].place.reset();
  const auto poses = walk.poses({along(0), along(0.4)});
  EXPECT_FALSE(poses[2].has_value());
  EXPECT_TRUE(poses[3].has_value());
}

TEST(KeyframeMotions, AreThoseBetweenTheFramesAround) {
  Vector6d motion;
  motion << 0.5, -1, 0.2, 0.3, 0.1, -0.4;  // rad/s, m/s
  std::vector<Frame> frames;
  std::vector<std::optional<RigidTransform>> poses;
  for (int i = 0; i < 5; ++i) {
    frames.push_back(frame(i, 0, {}));
    poses.emplace_back(
        RigidTransform::exp(static_cast<double>(i) * kFrame_ns * kSecondsPerNs * motion));
  }
  const std::vector<TimestampNs> times{2 * kFrame_ns, 4 * kFrame_ns};
  const std::vector<std::size_t> component{0, 0};
  const auto velocities = keyframe_velocities(frames, poses, {{}, times, component});
  for (const Vector6d& found : velocities) EXPECT_LT((found - motion).norm(), 0.03);
  const Eigen::Vector3d turning = motion.head<3>();
  for (const auto& found : keyframe_turning(frames, poses, {{}, times, component}))
    EXPECT_LT((found.value() - turning).norm(), 1e-6);

  // Three frames a second tell no motion, nor does a frame alone.
  for (Frame& each : frames) each.timestamp_ns *= 10;
  const std::vector<TimestampNs> later{20 * kFrame_ns, 40 * kFrame_ns};
  EXPECT_EQ(keyframe_velocities(frames, poses, {{}, later, component})[0], Vector6d::Zero());
  EXPECT_EQ(keyframe_velocities({}, {}, {{}, times, component})[0], Vector6d::Zero());
  // How it turned on the whole is known of the three; of a frame alone nothing is.
  for (const auto& found : keyframe_turning(frames, poses, {{}, later, component}))
    EXPECT_LT((found.value() - turning / 10).norm(), 1e-6);
  EXPECT_EQ(keyframe_turning({}, {}, {{}, times, component})[0], std::nullopt);
}

TEST(KeyframeMotions, AreNoJumpsBetweenWorlds) {
  const std::vector<Frame> frames{frame(0, 0, {}), frame(1, 0, along(0.01)), frame(2, 1, {})};
  const std::vector<std::optional<RigidTransform>> poses{along(0), along(0.01), along(50)};
  const std::vector<TimestampNs> times{kFrame_ns, 2 * kFrame_ns};
  const std::vector<std::size_t> component{0, 1};
  const auto velocities = keyframe_velocities(frames, poses, {{}, times, component});
  EXPECT_NEAR(velocities[0].tail<3>().x(), 0.01 / 0.03, 1e-9);
  EXPECT_EQ(velocities[1], Vector6d::Zero());
  const auto turning = keyframe_turning(frames, poses, {{}, times, component});
  EXPECT_EQ(turning[0], Eigen::Vector3d::Zero());
  EXPECT_EQ(turning[1], std::nullopt) << "not 0: it may have turned";
}

}  // namespace
}  // namespace roomwise::mapping
