#include "roomwise/guide/led/walker_track.h"

#include <gtest/gtest.h>

#include <cmath>

#include "roomwise/guide/testing/test_times.h"

namespace roomwise::guide {
namespace {

constexpr TimestampNs kHalf = kSecond / 2;

// A picture every half second, of somebody who walks along x and turns.
WalkerTrack track_of(double speed_m_s, double turning_rad_s, int pictures) {
  WalkerTrack track;
  for (int i = 0; i < pictures; ++i) {
    track.add({{0.5 * i * speed_m_s, 0}, 0.5 * i * turning_rad_s, 0.02}, kNow + i * kHalf);
  }
  return track;
}

TEST(WalkerTrackTest, TellsWhoStandsWalksAndTurns) {
  EXPECT_TRUE(track_of(0, 0, 4).is_standing());
  EXPECT_FALSE(track_of(0.6, 0, 4).is_standing());
  EXPECT_NEAR(*track_of(0.6, 0, 4).speed_m_s(), 0.6, 0.05);
  EXPECT_FALSE(track_of(0, 0, 4).may_turn());
  EXPECT_TRUE(track_of(0, 0.5, 4).may_turn());
  EXPECT_NEAR(track_of(0.6, 0, 11).walked_m(), 3, 0.3);
}

TEST(WalkerTrackTest, WhoTurnsOnTheSpotDoesNotWalkWhereverTheyHoldTheCamera) {
  EXPECT_TRUE(track_of(0.6, 0, 4).is_walking());
  EXPECT_FALSE(track_of(0.2, 0, 4).is_walking());
  constexpr double kHeld_m = 0.35;
  WalkerTrack turns;
  for (int i = 0; i < 4; ++i) {
    const double heading_rad = 0.6 * i;
    turns.add({kHeld_m * Eigen::Vector2d(std::cos(heading_rad), std::sin(heading_rad)), heading_rad,
               0.02},
              kNow + i * kHalf);
  }
  EXPECT_GT(*turns.speed_m_s(), kMinWalkingSpeed_m_s);
  EXPECT_FALSE(turns.is_walking());
  EXPECT_FALSE(WalkerTrack().is_walking());
}

TEST(WalkerTrackTest, WhatOnePictureDoesNotTellIsNotSaid) {
  EXPECT_FALSE(track_of(0, 0, 1).is_standing());
  EXPECT_TRUE(track_of(0, 0, 1).may_turn());
  EXPECT_EQ(track_of(0, 0, 1).speed_m_s(), std::nullopt);
}

TEST(WalkerTrackTest, WhoWalksGoesOnWhileSomebodySpeaks) {
  WalkerTrack track = track_of(0.6, 0, 5);  // to two seconds after kNow
  const TimestampNs newest_ns = kNow + 4 * kHalf;
  track.keep_pace(newest_ns + kHalf);
  EXPECT_NEAR(track.walked_since_m(), 0.3, 0.03);
  EXPECT_NEAR(track.left_when_heard_m(4, 1), 4 - 0.3 - 0.6 * (1 + kReaction_s), 0.15);
  WalkerTrack stands = track_of(0, 0, 5);
  stands.keep_pace(newest_ns + kHalf);
  EXPECT_EQ(stands.left_when_heard_m(4, 1), 4);
}

TEST(WalkerTrackTest, APoseGetsOld) {
  const WalkerTrack track = track_of(0, 0, 1);
  EXPECT_NE(track.pose(kNow + kSecond), nullptr);
  EXPECT_EQ(track.pose(kNow + 2 * kSecond), nullptr);
  EXPECT_EQ(track.age_s(kNow + 2 * kSecond), 2);
  EXPECT_EQ(WalkerTrack().pose(kNow), nullptr);
}

TEST(WalkerTrackTest, WhereNobodyCouldHaveWalkedIsBelievedByTwoPictures) {
  WalkerTrack track = track_of(0, 0, 3);  // to a second after kNow
  const Pose far{{5, 1}, 0, 0.02};
  track.add(far, kNow + 3 * kHalf);
  EXPECT_EQ(track.pose(kNow + 3 * kHalf)->position_plan.x(), 0);
  track.add(far, kNow + 4 * kHalf);
  EXPECT_EQ(track.pose(kNow + 4 * kHalf)->position_plan.x(), 5);
  // Nor does anybody turn about in half a second.
  track.add({{5, 1}, 3, 0.02}, kNow + 5 * kHalf);
  EXPECT_EQ(track.pose(kNow + 5 * kHalf)->heading_rad, 0);
}

}  // namespace
}  // namespace roomwise::guide
