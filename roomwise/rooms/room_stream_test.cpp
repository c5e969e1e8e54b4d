#include "roomwise/rooms/room_stream.h"

#include <gtest/gtest.h>

#include "roomwise/rooms/test_rooms.h"

namespace roomwise::rooms {
namespace {

RoomStream stream() {
  return {RoomTopology(kRooms, kWalk), calibration()};
}

TEST(RoomStream, GrowsSurerPictureByPicture) {
  RoomStream walk = stream();
  EXPECT_EQ(walk.see(evidence(0.1, 0.6, 0.3), 0).verdict, Verdict::kNotSure);
  RoomDecision decision;
  for (int i = 0; i < 4; ++i) decision = walk.see(evidence(0.1, 0.6, 0.3), 1);
  EXPECT_EQ(decision.room(), "hall");
}

TEST(RoomStream, KeepsTheRoomThroughOneWrongPicture) {
  RoomStream walk = stream();
  for (int i = 0; i < 6; ++i) (void)walk.see(evidence(0.02, 0.96, 0.02), 1);
  EXPECT_EQ(walk.see(evidence(0.2, 0.2, 0.6), 0.5).rooms.front().room, "hall");
}

TEST(RoomStream, APlaceThatIsUnknownForSecondsIsNoneOfThem) {
  RoomStream walk = stream();
  for (int i = 0; i < 3; ++i) (void)walk.see(evidence(0.02, 0.96, 0.02, 0), 1);
  EXPECT_EQ(walk.see(evidence(0.02, 0.96, 0.02, -3), 0.3).room(), "hall") << "one picture alone";
  RoomDecision decision;
  for (int i = 0; i < 8; ++i) decision = walk.see(evidence(0.02, 0.96, 0.02, -3), 1);
  EXPECT_EQ(decision.verdict, Verdict::kNoneOfThem);
}

TEST(RoomStream, TheFirstPictureSaysWhatItSaysAlone) {
  for (const double known : {0.0, -0.9, -1.1, -1.9, -2.1, -5.0}) {
    const PictureEvidence picture = evidence(0.02, 0.96, 0.02, known);
    EXPECT_EQ(stream().see(picture, 0).verdict, decide(picture, kRooms, calibration()).verdict)
        << known;
  }
}

TEST(RoomStream, AWallThatLooksLikeNothingTakesNobodyOutOfTheHome) {
  RoomStream walk = stream();
  for (int i = 0; i < 5; ++i) (void)walk.see(evidence(0.02, 0.96, 0.02, 0.5), 1.4);
  EXPECT_EQ(walk.see(evidence(0.3, 0.4, 0.3, -4), 1.4).room(), "hall");
}

TEST(RoomStream, AWallThatLooksLikeTheHallTakesNobodyIntoTheHome) {
  RoomStream walk = stream();
  for (int i = 0; i < 5; ++i) (void)walk.see(evidence(0.02, 0.96, 0.02, -2.5), 1.4);
  EXPECT_FALSE(walk.see(evidence(0.02, 0.96, 0.02, 0.5), 1.4).room());
  RoomDecision decision;
  for (int i = 0; i < 4; ++i) decision = walk.see(evidence(0.02, 0.96, 0.02, 0.5), 1.4);
  EXPECT_EQ(decision.room(), "hall") << "but several do";
}

TEST(RoomStream, WhatWasSeenMinutesAgoSaysNothing) {
  RoomStream walk = stream();
  for (int i = 0; i < 5; ++i) (void)walk.see(evidence(0.02, 0.96, 0.02, 0.5), 1.4);
  EXPECT_EQ(walk.see(evidence(0.02, 0.96, 0.02, -2.5), 1000).verdict, Verdict::kNoneOfThem);
}

TEST(RoomStream, ThatNoTimePassedSaysNothingMore) {
  RoomStream walk = stream();
  const double known = walk.see(evidence(0.02, 0.96, 0.02, -0.5), 0).known;
  for (int i = 0; i < 100; ++i) {
    EXPECT_NEAR(walk.see(evidence(0.02, 0.96, 0.02, -0.5), 0).known, known, 1e-9);
  }
}

}  // namespace
}  // namespace roomwise::rooms
