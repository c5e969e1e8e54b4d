#include "roomwise/rooms/recognition/room_stream.h"

#include <gtest/gtest.h>

#include "roomwise/rooms/testing/test_rooms.h"

namespace roomwise::rooms {
namespace {

RoomStream stream() {
  return {RoomTopology(kRooms, kWalk), test_model()};
}

TEST(RoomStream, GrowsSurerPictureByPicture) {
  RoomStream walk = stream();
  EXPECT_EQ(walk.update(evidence(0.1, 0.6, 0.3), 0).verdict, Verdict::kEither);
  RoomDecision decision;
  for (int i = 0; i < 9; ++i) decision = walk.update(evidence(0.1, 0.6, 0.3), 1);
  EXPECT_EQ(decision.room(), "hall");
}

TEST(RoomStream, KeepsTheRoomThroughOneWrongPicture) {
  RoomStream walk = stream();
  for (int i = 0; i < 6; ++i) (void)walk.update(evidence(0.02, 0.96, 0.02), 1);
  EXPECT_EQ(walk.update(evidence(0.2, 0.2, 0.6), 0.5).rooms.front().room, "hall");
}

TEST(RoomStream, APlaceThatIsUnknownForSecondsIsNoneOfThem) {
  RoomStream walk = stream();
  for (int i = 0; i < 3; ++i) (void)walk.update(evidence(0.02, 0.96, 0.02, 8), 1);
  EXPECT_EQ(walk.update(evidence(0.02, 0.96, 0.02, -8), 0.1).room(), "hall") << "one picture alone";
  RoomDecision decision;
  for (int i = 0; i < 8; ++i) decision = walk.update(evidence(0.02, 0.96, 0.02, -8), 1);
  EXPECT_EQ(decision.verdict, Verdict::kNoneOfThem);
}

}  // namespace
}  // namespace roomwise::rooms
