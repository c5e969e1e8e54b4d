#include "roomwise/guide/led/in_the_way.h"

#include <gtest/gtest.h>

#include "roomwise/guide/testing/drawn_floor.h"
#include "roomwise/guide/testing/test_times.h"

namespace roomwise::guide {
namespace {

using Eigen::Vector2d;
using fusion::FloorCell;

// Along a floor of 14 m by 2.4 m, with a table whose edge is at y = 1.1 m.
class HazardWatchTest : public ::testing::Test {
 protected:
  HazardWatchTest() { way_.plan_from({.pose = Pose{{0.6, 1.6}, 0, 0.02}}, floor_); }

  [[nodiscard]] static Goal spot() {
    Goal goal;
    goal.kind = Goal::Kind::kSpot;
    goal.noun = {Noun::Kind::kThing, "my place"};
    goal.outline = Outline{{13, 1.6}};
    return goal;
  }
  std::optional<InTheWay> look(const Pose& pose, const Vector2d& obstacle, double at_s) {
    const auto at_ns = kNow + static_cast<TimestampNs>(at_s * kSecond);
    return watch_.look(way_, pose, {&obstacle, 1}, floor_, at_ns);
  }

  const fusion::FloorGrid grid_ =
      testing::Floor(140, 24).fill({50, 1}, {56, 11}, FloorCell::kOccupied).grid();
  BarredFloor floor_{&grid_};
  FollowedWay way_{{&grid_}, spot(), {}};
  HazardWatch watch_;
};

TEST_F(HazardWatchTest, WhatIsNewIsFoundABodysWidthAboutTheLine) {
  const Pose pose{{2, 1.6}, 0, 0.02};
  EXPECT_FALSE(look(pose, {2.8, 2.0}, 0)) << "beside it";
  EXPECT_FALSE(look(pose, {3.4, 1.6}, 0)) << "too far ahead";
  EXPECT_FALSE(look(pose, {1.5, 1.6}, 0)) << "behind";
  const auto obstacle = look(pose, {2.8, 1.8}, 0);
  ASSERT_TRUE(obstacle);
  EXPECT_FALSE(obstacle->is_on_map);
  EXPECT_NEAR(obstacle->ahead_m(), 0.8, 0.02);
  EXPECT_EQ(obstacle->side_by(pose), ObstacleAhead::Side::kLeft);
  EXPECT_EQ(obstacle->side_by({{2, 1.6}, 0.6}), ObstacleAhead::Side::kRight)
      << "of who looks to the left of it";
}

TEST_F(HazardWatchTest, ItIsFoundAgainAfterSomeSeconds) {
  const Pose pose{{2, 1.6}, 0, 0.02};
  EXPECT_TRUE(look(pose, {2.8, 1.6}, 0));
  EXPECT_FALSE(look(pose, {2.8, 1.6}, 3));
  EXPECT_TRUE(look(pose, {2.8, 1.6}, 4));
}

TEST_F(HazardWatchTest, WhatTheMapKnowsIsFoundOnceWhereTheyHaveLeftTheLine) {
  const Vector2d table(5.05, 1.05);
  EXPECT_FALSE(look({{4.3, 1.6}, 0, 0.02}, table, 0)) << "the way leads past it";
  const Pose aside{{4.3, 1.05}, 0, 0.02};
  const auto obstacle = look(aside, table, 0);
  ASSERT_TRUE(obstacle);
  EXPECT_TRUE(obstacle->is_on_map);
  EXPECT_FALSE(look(aside, table, 10)) << "they know it";
  EXPECT_FALSE(look({{2, 1.6}, 0, 0.02}, table, 20));
  EXPECT_TRUE(look(aside, table, 30)) << "who comes back";
}

}  // namespace
}  // namespace roomwise::guide
