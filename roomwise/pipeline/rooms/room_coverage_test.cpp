#include "roomwise/pipeline/rooms/room_coverage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/pipeline/testing/mapped_room.h"

namespace roomwise::pipeline {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

RoomLight light(double brightness, double spread) {
  return {brightness, brightness - spread / 2, brightness + spread / 2, 1.2, 1.1, 1.3};
}

RoomOnWalk on_walk(home::RecordingId walk, std::size_t pictures,
                   std::optional<RoomLight> light = std::nullopt) {
  return {walk, pictures, 0, 0, light};
}

std::vector<std::string> words(const RoomCoverage& coverage) {
  std::vector<std::string> words;
  for (const CoverageItem& item : missing_items(coverage, {})) {
    words.push_back(fmt::format("{}: {}", item.room, to_string(item.what)));
  }
  return words;
}

TEST(RoomCoverages, TwoLightsDifferWhereTheirMediansLieFartherApartThanTheirPictures) {
  EXPECT_TRUE(light(0.6, 0.1).differs_from(light(0.4, 0.1)));
  EXPECT_FALSE(light(0.6, 0.3).differs_from(light(0.4, 0.1))) << "the room is lit unevenly";
  RoomLight lamps = light(0.6, 0.3);
  lamps.red_over_blue = 2;
  EXPECT_TRUE(light(0.6, 0.3).differs_from(lamps)) << "as bright, and redder";
}

TEST(RoomCoverages, ARoomOfTwoWalksByTwoLightsLacksNothing) {
  RoomCoverage coverage;
  coverage.rooms = {{"hall", {on_walk(1, 30, light(0.6, 0.1)), on_walk(2, 30, light(0.3, 0.1))}}};
  EXPECT_THAT(words(coverage), IsEmpty());
}

TEST(RoomCoverages, AWalkWhosePicturesWereCulledIsNotAskedForAgain) {
  RoomCoverage coverage;
  coverage.rooms = {
      {"bath", {on_walk(1, 30, light(0.6, 0.1)), on_walk(2, 0)}},
      {"hall", {on_walk(1, 30, light(0.6, 0.1)), on_walk(2, 0), on_walk(3, 9, light(0.3, 0.1))}}};
  EXPECT_THAT(words(coverage), ElementsAre("bath: other light"));
}

TEST(RoomCoverages, ARoomThatFurtherPicturesWouldShowNothingNewOfIsNotAskedForMore) {
  RoomCoverage coverage;
  const RoomOnWalk by_day = on_walk(1, 12, light(0.6, 0.1)),
                   by_night = on_walk(2, 4, light(0.3, 0.1));
  coverage.rooms = {{"bath", {by_day, by_night, on_walk(3, 0)}},
                    {"hall", {by_day, by_night}, 31},
                    {"loft", {on_walk(1, 4, light(0.6, 0.1)), on_walk(3, 0)}, 31},
                    {"study", {by_day, by_night}, 19}};
  EXPECT_THAT(words(coverage),
              ElementsAre("loft: pictures", "study: more pictures", "loft: other light"))
      << "learning anew needs some in any case";
}

TEST(RoomCoverages, SayWhatEachRoomLacks) {
  RoomCoverage coverage;
  coverage.rooms = {{"bath", {on_walk(1, 30, light(0.6, 0.1)), on_walk(2, 30, light(0.6, 0.1))}},
                    {"hall", {on_walk(1, 4)}},
                    {"kitchen", {on_walk(1, 12), on_walk(2, 5)}},
                    {"loft", {}}};
  EXPECT_THAT(words(coverage),
              ElementsAre("hall: pictures", "loft: pictures", "kitchen: more pictures",
                          "hall: second walk", "bath: other light"));
}

TEST(RoomCoverages, SayWhatBecameOfWalks) {
  RoomCoverage coverage;
  coverage.walks.resize(2);
  coverage.walks[0].id = 4;
  coverage.walks[1].id = 7;
  coverage.not_joined = {7};
  coverage.unnamed = {3, 0};
  const auto items = missing_items(coverage, {});
  ASSERT_EQ(items.size(), 2U);
  EXPECT_EQ(items[0].what, Missing::kJoin);
  EXPECT_EQ(items[0].walk, 7);
  EXPECT_EQ(items[1].what, Missing::kNames);
  EXPECT_EQ(items[1].walk, 4);
  EXPECT_EQ(items[1].pictures, 3U);
}

class CoverageOfMappedRoom : public testing::MappedRoom {
 protected:
  void SetUp() override {
    MappedRoom::SetUp();
    ASSERT_OK(home_->replace_rooms(std::vector<rooms::Room>{{"hall", "hall"}}));
    ASSERT_OK(home_->replace_room_ranges(1, {{0, kKeyframes - 1, "hall", 1}}));
  }
};

TEST_F(CoverageOfMappedRoom, FloorThatWasWalkedAroundLacksNothing) {
  const auto coverage = find_room_coverage(*home_, {}, run_);
  ASSERT_OK(coverage);
  EXPECT_TRUE(coverage->knows_floor);
  EXPECT_THAT(coverage->gaps, IsEmpty());
  EXPECT_THAT(coverage->not_joined, IsEmpty());
  EXPECT_THAT(coverage->unnamed, ElementsAre(0U));
  ASSERT_EQ(coverage->rooms.size(), 1U);
  ASSERT_EQ(coverage->rooms[0].walks.size(), 1U);
  EXPECT_EQ(coverage->rooms[0].walks[0].pictures, kKeyframes);
  ASSERT_TRUE(coverage->rooms[0].walks[0].light);
  EXPECT_GT(coverage->rooms[0].walks[0].light->brightness, 0);
}

TEST_F(CoverageOfMappedRoom, FloorThatNoCameraCameNearIsToldWithItsPlace) {
  CoverageOptions options;
  options.floor.near_m = 0.6;  // all cameras stand near the middle
  const auto coverage = find_room_coverage(*home_, options, run_);
  ASSERT_OK(coverage);
  ASSERT_FALSE(coverage->gaps.empty());
  const FloorGap& gap = coverage->gaps.front();
  EXPECT_EQ(gap.room, "hall");
  EXPECT_FALSE(gap.is_unseen) << "its floor was seen, from afar";
  EXPECT_GE(gap.length_m, options.floor.min_gap_m);
}

TEST_F(CoverageOfMappedRoom, WrongOptionsAreRefused) {
  CoverageOptions options;
  options.floor.near_m = 0;
  EXPECT_ERROR(find_room_coverage(*home_, options, run_), "near_m is 0");
}

}  // namespace
}  // namespace roomwise::pipeline
