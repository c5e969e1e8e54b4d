#include "roomwise/pipeline/mapping/walked_floor.h"

#include <gtest/gtest.h>

#include <cmath>

namespace roomwise::pipeline {
namespace {

using fusion::FloorCell;

// Key-frames every half second, half a metre apart, along x at y = 1, 1.4 m up.
std::vector<home::Keyframe> walk(int count) {
  std::vector<home::Keyframe> keyframes(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    home::Keyframe& one = keyframes[static_cast<std::size_t>(i)];
    one.id = i + 1;
    one.recording = 1;
    one.timestamp_ns = i * 500'000'000LL;
    one.pose.world_from_keyframe.translation = {0.5 + 0.5 * i, 1, 1.4};
  }
  return keyframes;
}

// 4 x 2 m of which nothing is known, but for a thing on the way.
fusion::FloorGrid floor() {
  image::Image<FloorCell> cells(40, 20, FloorCell::kUnknown);
  cells.at(20, 10) = FloorCell::kOccupied;
  return {Eigen::Vector2d::Zero(), 0.1, std::move(cells)};
}

TEST(WalkedFloorTest, IsFreeAsWideAsAPersonAlongTheWalkAndNowhereElse) {
  const auto walked = with_walked_ways(floor(), {}, walk(5));  // to x = 2.5
  EXPECT_EQ(walked.at({1.23, 1.05}), FloorCell::kFree);
  EXPECT_EQ(walked.at({1.23, 1.15}), FloorCell::kFree);
  EXPECT_EQ(walked.at({1.23, 1.35}), FloorCell::kUnknown);
  EXPECT_EQ(walked.at({3.05, 1.05}), FloorCell::kUnknown);
  EXPECT_EQ(walked.at({0.05, 1.05}), FloorCell::kUnknown);
}

TEST(WalkedFloorTest, WhatWasSeenOccupiedStaysSo) {
  EXPECT_EQ(with_walked_ways(floor(), {}, walk(5)).at({2.05, 1.05}), FloorCell::kOccupied);
}

TEST(WalkedFloorTest, NothingIsWalkedBetweenKeyframesThatDoNotFollowEachOther) {
  const auto free_cells = [](std::vector<home::Keyframe> keyframes) {
    return with_walked_ways(floor(), {}, keyframes).count(FloorCell::kFree);
  };
  auto late = walk(2);
  late[1].timestamp_ns = 3'000'000'000;
  EXPECT_EQ(free_cells(late), 0u);
  auto far = walk(2);
  far[1].pose.world_from_keyframe.translation.x() = 2;
  EXPECT_EQ(free_cells(far), 0u);
  auto others = walk(2);
  others[1].recording = 2;
  EXPECT_EQ(free_cells(others), 0u);
  EXPECT_GT(free_cells(walk(2)), 0u);
}

}  // namespace
}  // namespace roomwise::pipeline
