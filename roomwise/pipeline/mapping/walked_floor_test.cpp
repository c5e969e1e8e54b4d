#include "roomwise/pipeline/mapping/walked_floor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace roomwise::pipeline {
namespace {

using fusion::FloorCell;

// Frames every half second, half a metre apart, along x at y = 1, 1.4 m up.
std::vector<WalkedFrame> walk(int count) {
  std::vector<WalkedFrame> frames(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    WalkedFrame& one = frames[static_cast<std::size_t>(i)];
    one.recording = 1;
    one.timestamp_ns = i * 500'000'000LL;
    one.at_world = {0.5 + 0.5 * i, 1, 1.4};
  }
  return frames;
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

std::size_t free_cells(const std::vector<WalkedFrame>& frames) {
  return with_walked_ways(floor(), {}, frames).count(FloorCell::kFree);
}

TEST(WalkedFloorTest, NothingIsWalkedBetweenFramesThatDoNotFollowEachOther) {
  auto late = walk(4);
  for (std::size_t i : {1, 2, 3}) late[i].timestamp_ns += 3'000'000'000;
  EXPECT_EQ(with_walked_ways(floor(), {}, late).at({0.75, 1.05}), FloorCell::kUnknown);
  auto far = walk(4);
  for (std::size_t i : {1, 2, 3}) far[i].at_world.x() += 1;
  EXPECT_EQ(with_walked_ways(floor(), {}, far).at({0.75, 1.05}), FloorCell::kUnknown);
  auto others = walk(4);
  for (std::size_t i : {1, 2, 3}) others[i].recording = 2;
  EXPECT_EQ(with_walked_ways(floor(), {}, others).at({0.75, 1.05}), FloorCell::kUnknown);
  EXPECT_EQ(with_walked_ways(floor(), {}, walk(4)).at({0.75, 1.05}), FloorCell::kFree);
}

// Frames every 10 cm along x from 0 at y = 1; how high the camera is over the floor where a
// walk began, by how far it has come.
template <typename Height>
std::vector<WalkedFrame> dense_walk(double length_m, const Height& height_m) {
  std::vector<WalkedFrame> frames;
  for (int i = 0; 0.1 * i <= length_m; ++i) {
    WalkedFrame& one = frames.emplace_back();
    one.recording = 1;
    one.timestamp_ns = i * 100'000'000LL;
    one.at_world = {0.1 * i, 1, height_m(0.1 * i)};
  }
  return frames;
}

// The last free cell's middle along the walk, in m; 0: none is.
double free_up_to_m(const fusion::FloorGrid& floor) {
  double last_m = 0;
  for (double x = 0.05; x < 4; x += 0.1)
    if (floor.at({x, 1.05}) == FloorCell::kFree) last_m = x;
  return last_m;
}

fusion::FloorGrid unknown_floor() {
  return {Eigen::Vector2d::Zero(), 0.1, image::Image<FloorCell>(40, 20, FloorCell::kUnknown)};
}

TEST(WalkedFloorTest, StepsDownThatNobodyRecognisedAreNoFloor) {
  // The edge is at 2 m. The camera is carried half a metre ahead of the feet, and sinks with them.
  for (const double steepness : {0.5, 0.65, 0.9}) {
    const auto down =
        dense_walk(4, [&](double x) { return 1.4 - std::max(0.0, steepness * (x - 2.5)); });
    const double last_m = free_up_to_m(with_walked_ways(unknown_floor(), {}, down));
    EXPECT_LT(last_m, 2) << steepness;
    EXPECT_GT(last_m, 1.5) << steepness;
  }
}

TEST(WalkedFloorTest, FloorIsWalkedUpToStairsThatWereRecognised) {
  fusion::Staircase stairs;
  stairs.foot_gravity = {4, 1};
  stairs.top_gravity = {2, 1};  // where the camera comes to them they begin to lead down
  fusion::GravityAlignedFrame frame;
  frame.storeys = fusion::Storeys({{-2.6, {0, 0}}, {0, {0, 0}, -10}}, {stairs});
  const auto down = dense_walk(4, [&](double x) { return 1.4 - std::max(0.0, 0.65 * (x - 2.5)); });
  const auto walked = with_walked_ways(unknown_floor(), frame, down);
  EXPECT_EQ(walked.at({1.85, 1.05}), FloorCell::kFree);
  EXPECT_EQ(walked.at({2.25, 1.05}), FloorCell::kUnknown);
}

TEST(WalkedFloorTest, StepsUpThatNobodyRecognisedAreNoFloor) {
  const auto up = dense_walk(4, [](double x) { return 1.4 + std::max(0.0, 0.65 * (x - 2.2)); });
  EXPECT_LT(free_up_to_m(with_walked_ways(unknown_floor(), {}, up)), 2);
}

TEST(WalkedFloorTest, WhereTheWalkWasLostInFrontOfStairsNothingAheadOfTheFeetIsFloor) {
  // The edge is at 2 m, and the camera was last placed over the first tread.
  const auto lost = dense_walk(2.5, [](double) { return 1.4; });
  EXPECT_LT(free_up_to_m(with_walked_ways(unknown_floor(), {}, lost)), 2);
}

TEST(WalkedFloorTest, ALandingOneStepLowerIsNoFloorOfTheStorey) {
  const auto landing =
      dense_walk(4, [](double x) { return 1.4 - std::clamp(0.65 * (x - 2.5), 0.0, 0.14); });
  EXPECT_LT(free_up_to_m(with_walked_ways(unknown_floor(), {}, landing)), 2);
}

TEST(WalkedFloorTest, AnotherLevelThatIsNoStoreyIsNoFloor) {
  // Most of this walk was a floor higher than the one that the map knows.
  EXPECT_EQ(free_cells(dense_walk(4, [](double) { return 1.4 + 2.7; })), 0u);
}

TEST(WalkedFloorTest, ALadderIsNoFloor) {
  auto ladder = dense_walk(2, [](double) { return 1.4; });
  const auto climbed = dense_walk(1.5, [](double) { return 0.0; });
  for (const WalkedFrame& one : climbed) {
    const double up_m = one.at_world.x();
    WalkedFrame& higher = ladder.emplace_back(ladder.back());
    higher.timestamp_ns += 100'000'000;
    higher.at_world = {2 + 0.1 * up_m, 1, 1.4 + up_m};
  }
  const double last_m = free_up_to_m(with_walked_ways(unknown_floor(), {}, ladder));
  EXPECT_LT(last_m, 1.5);
  EXPECT_GT(last_m, 0.9);
}

TEST(WalkedFloorTest, ALevelWalkMayBobAsWalkersDo) {
  const auto bobbing = dense_walk(4, [](double x) { return 1.4 + 0.04 * std::sin(9 * x); });
  const auto walked = with_walked_ways(unknown_floor(), {}, bobbing);
  for (double x = 0.05; x < 3; x += 0.1) EXPECT_EQ(walked.at({x, 1.05}), FloorCell::kFree) << x;
}

TEST(WalkedFloorTest, WhoStandsStillOnTheWayWalksOn) {
  const auto on = walk(7);
  auto lost = on;
  for (std::size_t i = 3; i < lost.size(); ++i) lost[i].timestamp_ns += 10'000'000'000;
  auto pausing = lost;
  for (int i = 0; i < 100; ++i) {
    WalkedFrame still = on[2];
    still.timestamp_ns += i * 100'000'000LL;
    still.at_world.x() += i % 2 == 0 ? 0 : 0.01;
    pausing.insert(pausing.begin() + 3 + i, still);
  }
  EXPECT_EQ(free_cells(pausing), free_cells(on));
  EXPECT_LT(free_cells(lost), free_cells(on)) << "nobody knows where those ten seconds were spent";
}

TEST(WalkedFloorTest, WhereOneTurnsBackIsFloor) {
  auto there_and_back = dense_walk(2, [](double) { return 1.4; });
  for (std::size_t i = there_and_back.size() - 1; i-- > 0;) {
    WalkedFrame& back = there_and_back.emplace_back(there_and_back[i]);
    back.timestamp_ns = static_cast<TimestampNs>(there_and_back.size()) * 100'000'000;
  }
  EXPECT_GT(free_up_to_m(with_walked_ways(unknown_floor(), {}, there_and_back)), 2);
}

}  // namespace
}  // namespace roomwise::pipeline
