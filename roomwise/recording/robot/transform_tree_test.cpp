#include "roomwise/recording/robot/transform_tree.h"

#include <gmock/gmock.h>

#include <numbers>

namespace roomwise::recording {
namespace {

constexpr TimestampNs kTreeSecond = 1'000'000'000;

TransformMessage link(const std::string& parent, const std::string& child, TimestampNs time,
                      double x, double turn_rad = 0) {
  const Eigen::AngleAxisd turn(turn_rad, Eigen::Vector3d::UnitZ());
  return {{time, parent}, child, {Eigen::Quaterniond(turn), {x, 0, 0}}};
}

TEST(TransformTree, JoinsFramesAlongTheirChain) {
  TransformTree tree;
  tree.add(link("map", "odom", 0, 1));
  tree.add(link("odom", "base", 0, 2, std::numbers::pi / 2));
  tree.add(link("base", "camera", 0, 3));
  tree.add(link("base", "depth", 0, 3.5));
  tree.sort();
  EXPECT_EQ(tree.root_of("camera"), "map");
  const auto map_from_camera = tree.look_up("map", "camera", kTreeSecond);
  ASSERT_TRUE(map_from_camera);
  // Base looks along y, so the camera is 3 m in y from it.
  EXPECT_TRUE(map_from_camera->translation.isApprox(Eigen::Vector3d(3, 3, 0)));
  const auto camera_from_depth = tree.look_up("camera", "depth", kTreeSecond);
  ASSERT_TRUE(camera_from_depth);
  EXPECT_TRUE(camera_from_depth->translation.isApprox(Eigen::Vector3d(0.5, 0, 0)));
  EXPECT_FALSE(tree.moves("camera", "map"));
}

TEST(TransformTree, FramesThatAreNotConnectedHaveNoTransform) {
  TransformTree tree;
  tree.add(link("map", "odom", 0, 1));
  tree.add(link("other", "camera", 0, 1));
  EXPECT_FALSE(tree.look_up("map", "camera", 0));
  EXPECT_FALSE(tree.look_up("map", "unknown", 0));
  EXPECT_TRUE(tree.look_up("unknown", "unknown", 0));
}

TEST(TransformTree, WhatMovesIsInterpolatedNearItsTimesOnly) {
  TransformTree tree;
  tree.add(link("odom", "base", 10 * kTreeSecond, 0));
  tree.add(link("odom", "base", 10 * kTreeSecond + kTreeSecond / 2, 2, 1));
  tree.add(link("odom", "base", 15 * kTreeSecond, 4));
  tree.sort();
  EXPECT_TRUE(tree.moves("base", "odom"));
  const auto between = tree.look_up("odom", "base", 10 * kTreeSecond + kTreeSecond / 4);
  ASSERT_TRUE(between);
  EXPECT_NEAR(between->translation.x(), 1, 1e-9);
  EXPECT_NEAR(between->angle_rad(), 0.5, 1e-9);
  EXPECT_FALSE(tree.look_up("odom", "base", 12 * kTreeSecond)) << "a gap of more than a second";
  EXPECT_TRUE(tree.look_up("odom", "base", 15 * kTreeSecond + kTreeSecond / 20));
  EXPECT_FALSE(tree.look_up("odom", "base", 16 * kTreeSecond));
  EXPECT_FALSE(tree.look_up("odom", "base", 9 * kTreeSecond));
}

TEST(TransformTree, WhatNeverMovesIsKnownAtAnyTime) {
  TransformTree tree;
  for (int i = 0; i < 100; ++i)
    tree.add(link("base", "camera", 100 * kTreeSecond + i * kTreeSecond / 10, 0.25));
  tree.sort();
  EXPECT_TRUE(tree.look_up("base", "camera", 0));
  EXPECT_FALSE(tree.moves("base", "camera"));
}

TEST(TransformTree, WhatStoodStillAndThenMovesStandsStillUntilThen) {
  TransformTree tree;
  for (int i = 0; i <= 200; ++i) tree.add(link("odom", "base", i * kTreeSecond / 10, 0));
  tree.add(link("odom", "base", 201 * kTreeSecond / 10, 1));
  tree.sort();
  EXPECT_NEAR(tree.look_up("odom", "base", 401 * kTreeSecond / 20)->translation.x(), 0.5, 1e-9);
  for (int i = 0; i <= 400; ++i) {
    const auto still = tree.look_up("odom", "base", i * kTreeSecond / 20);
    ASSERT_TRUE(still) << i;
    EXPECT_NEAR(still->translation.x(), 0, 1e-9);
  }
}

TEST(TransformTree, WhatStoodStillIsNotKnownWithinAGap) {
  TransformTree tree;
  for (int i = 0; i <= 100; ++i) {
    if (i < 50 || i > 70) tree.add(link("odom", "base", i * kTreeSecond / 10, 0));
  }
  tree.add(link("odom", "base", 101 * kTreeSecond / 10, 1));
  tree.sort();
  EXPECT_TRUE(tree.look_up("odom", "base", 49 * kTreeSecond / 10));
  EXPECT_FALSE(tree.look_up("odom", "base", 6 * kTreeSecond));
  EXPECT_TRUE(tree.look_up("odom", "base", 71 * kTreeSecond / 10));
}

TEST(TransformTree, ACircleEndsSomewhere) {
  TransformTree tree;
  tree.add(link("a", "b", 0, 1));
  tree.add(link("b", "a", 0, 1));
  tree.add(link("c", "c", 0, 1));
  tree.sort();
  EXPECT_FALSE(tree.root_of("a").empty());
  EXPECT_FALSE(tree.root_of("c").empty());
  std::ignore = tree.look_up("a", "b", 0);
  EXPECT_FALSE(tree.look_up("a", "c", 0));
}

}  // namespace
}  // namespace roomwise::recording
