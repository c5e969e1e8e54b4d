#include "roomwise/pipeline/stored/stored_rooms.h"

#include <gmock/gmock.h>

#include "roomwise/home/testing/sample_home.h"

namespace roomwise::pipeline {
namespace {

using ::testing::Optional;
using ::testing::Pair;
using ::testing::UnorderedElementsAre;

// A hall of 3 m by 2 m, all free.
rooms::RoomLayout hall() {
  const image::Image<fusion::FloorCell> cells(30, 20, fusion::FloorCell::kFree);
  rooms::WalkedPath walk;
  for (double x_m = 0.5; x_m < 2.5; x_m += 0.1) walk.push_back({{x_m, 1}, "hall"});
  return rooms::RoomLayout::make({Eigen::Vector2d::Zero(), 0.1, cells}, std::span(&walk, 1))
      .value();
}

TEST(StoredRooms, KeyframesHaveTheRoomsOfTheirFrames) {
  const roomwise::testing::ScratchFolder folder;
  home::Home home = home::Home::create(folder / "a.home").value();
  ROOMWISE_MUST(home.add_recording(home::testing::sample_recording()));
  for (home::KeyframeId id = 0; id < 4; ++id) {
    ROOMWISE_MUST(home.add_network(home::testing::sample_network()));
    ROOMWISE_MUST(home.commit(home::testing::sample_commit(1, 1, id)));
  }
  EXPECT_TRUE(rooms_of_keyframes(home)->empty());
  ROOMWISE_MUST(home.replace_rooms(std::vector<rooms::Room>{{"hall", "hall"}, {"bath", "bath"}}));
  const auto keyframes = home.keyframes().value();
  ROOMWISE_MUST(home.replace_room_ranges(
      1, {{0, keyframes[1].frame_index, "hall", 1},
          {keyframes[3].frame_index, keyframes[3].frame_index + 5, "bath", 1}}));
  EXPECT_THAT(*rooms_of_keyframes(home),
              UnorderedElementsAre(Pair(0, "hall"), Pair(1, "hall"), Pair(3, "bath")));
}

TEST(StoredRooms, AThingStandsWhereItsMiddleLiesElseWhereItIsSeenBest) {
  const rooms::RoomLayout layout = hall();
  const KeyframeRooms rooms{{7, "bath"}};
  const Eigen::Vector3d in_hall(1, 1, 0.5);
  EXPECT_THAT(room_of_thing(in_hall, 7, &layout, rooms), Optional(std::string("hall")))
      << "it is seen through the door";
  EXPECT_THAT(room_of_thing(in_hall, 7, nullptr, rooms), Optional(std::string("bath")));
  EXPECT_THAT(room_of_thing({}, 7, &layout, rooms), Optional(std::string("bath")));
  EXPECT_THAT(room_of_thing(Eigen::Vector3d(50, 1, 0.5), 7, &layout, rooms),
              Optional(std::string("bath")))
      << "outside of all floors";
  EXPECT_EQ(room_of_thing(Eigen::Vector3d(50, 1, 0.5), 8, &layout, rooms), std::nullopt);
}

TEST(StoredRooms, OnlyTheLargestComponentIsOnTheMap) {
  const objects::Instance thing = home::testing::sample_instance(0);
  home::KeyframePose pose{{Eigen::Quaterniond::Identity(), {1, 2, 3}}, 0};
  const auto middle = middle_on_map(thing, pose, {});
  ASSERT_TRUE(middle);
  EXPECT_TRUE(middle->isApprox(thing.box_keyframe.center() + Eigen::Vector3d(1, 2, 3)));
  pose.component = 1;
  EXPECT_EQ(middle_on_map(thing, pose, {}), std::nullopt);
}

}  // namespace
}  // namespace roomwise::pipeline
