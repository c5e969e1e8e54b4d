#include "roomwise/guide/led/barred_floor.h"

#include <gtest/gtest.h>

#include <numbers>

#include "roomwise/guide/testing/drawn_floor.h"
#include "roomwise/guide/testing/test_times.h"

namespace roomwise::guide {
namespace {

using Eigen::Vector2d;
using fusion::FloorCell;

// A floor of 4 m by 4 m, with a block whose nearer edge is at x = 3 m.
class BarredFloorTest : public ::testing::Test {
 protected:
  const fusion::FloorGrid grid_ =
      testing::Floor(40, 40).fill({30, 10}, {39, 30}, FloorCell::kOccupied).grid();
  BarredFloor floor_{&grid_};
  const Pose pose_{{1, 2}, 0, 0.02};  // faces the block
};

TEST_F(BarredFloorTest, WhatACaneFoundIsAsBroadAsToldFromWhereItTouchedIt) {
  floor_.bar_ahead(pose_, 0.25, kNow);
  EXPECT_EQ(floor_.grid()->at(Vector2d(1.45, 2)), FloorCell::kOccupied);
  EXPECT_EQ(floor_.grid()->at(Vector2d(1.75, 2)), FloorCell::kOccupied);
  EXPECT_EQ(floor_.grid()->at(Vector2d(1.2, 2)), FloorCell::kFree);
  EXPECT_EQ(floor_.grid()->at(Vector2d(1.6, 2.35)), FloorCell::kFree);
  EXPECT_EQ(grid_.at(Vector2d(1.6, 2)), FloorCell::kFree) << "the map stays as it is";
  floor_.clear();
  EXPECT_EQ(floor_.grid(), &grid_);
}

TEST_F(BarredFloorTest, WhatTheMapKnowsIsNotBarredOnceMore) {
  const Vector2d known(2.95, 2), unknown(2, 2);
  const std::vector seen{known, unknown};
  floor_.bar_seen(seen, kNow);
  EXPECT_EQ(floor_.grid()->at(unknown), FloorCell::kOccupied);
  EXPECT_EQ(floor_.grid()->at(known), FloorCell::kFree);
}

TEST_F(BarredFloorTest, WhatWasFoundIsForgottenAWhileAfterItWasSeenLast) {
  const Vector2d first(1, 1), second(2, 2);
  const auto is_barred = [&](const Vector2d& place) {
    return floor_.grid()->at(place) == FloorCell::kOccupied;
  };
  floor_.bar_seen({&first, 1}, kNow);
  floor_.bar_seen({&second, 1}, kNow);
  floor_.forget_old(after(kNow, kBarred_s - 1));
  EXPECT_TRUE(is_barred(first) && is_barred(second));
  const std::size_t places = floor_.places().size();
  floor_.bar_seen({&second, 1}, after(kNow, kBarred_s - 1));
  EXPECT_EQ(floor_.places().size(), places) << "the same";
  floor_.forget_old(after(kNow, kBarred_s));
  EXPECT_FALSE(is_barred(first));
  EXPECT_TRUE(is_barred(second));
  floor_.forget_old(after(kNow, 2 * kBarred_s));
  EXPECT_EQ(floor_.grid(), &grid_);
}

TEST_F(BarredFloorTest, WhatWasFoundBeforeBarsTheFloorOfWhoAsksNext) {
  const Vector2d seen(2, 2);
  floor_.bar_seen({&seen, 1}, kNow);
  BarredFloor next(&grid_, floor_.places());
  EXPECT_EQ(next.grid()->at(seen), FloorCell::kOccupied);
  next.forget_old(after(kNow, kBarred_s));
  EXPECT_EQ(next.grid(), &grid_);
  EXPECT_EQ(BarredFloor(nullptr, floor_.places()).grid(), nullptr);
}

TEST_F(BarredFloorTest, TriesAreCountedAtOnePlace) {
  EXPECT_FALSE(floor_.was_barred_at(pose_));
  floor_.count_try(pose_);
  floor_.count_try({{1.3, 2}});
  EXPECT_EQ(floor_.tries(), 2);
  EXPECT_TRUE(floor_.was_barred_at(pose_));
  const Pose elsewhere{{3, 0.5}};
  EXPECT_FALSE(floor_.was_barred_at(elsewhere));
  floor_.count_try(elsewhere);
  EXPECT_EQ(floor_.tries(), 1);
}

TEST_F(BarredFloorTest, TheFreerSideIsWhereNothingStands) {
  EXPECT_EQ(floor_.freer_side({{1, 0.35}, 0}), 1) << "a wall on the right";
  EXPECT_EQ(floor_.freer_side({{1, 0.35}, std::numbers::pi}), -1);
}

TEST_F(BarredFloorTest, WhoStandsNearerToThingsThanWaysLeadMayGoAlongThem) {
  EXPECT_EQ(floor_.narrow_m_at({1.5, 2}, 0.22), 0.22);
  EXPECT_LT(floor_.narrow_m_at({2.85, 2}, 0.22), 0.12);
  EXPECT_EQ(floor_.narrow_m_at({3.5, 2}, 0.22), 0) << "where the map has the block";
}

}  // namespace
}  // namespace roomwise::guide
