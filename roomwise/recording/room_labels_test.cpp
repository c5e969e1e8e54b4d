#include "roomwise/recording/room_labels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::recording {
namespace {

using roomwise::testing::ScratchFolder;
using ::testing::ElementsAre;

class RoomLabelsFile : public ::testing::Test {
 protected:
  Expected<RoomLabels> read(std::string_view text) {
    EXPECT_OK(write_file(path_, text));
    return RoomLabels::read(path_);
  }
  [[nodiscard]] std::string line(int number) const {
    return fmt::format("{}:{}", path_.string(), number);
  }

  ScratchFolder folder_;
  std::filesystem::path path_ = folder_ / "rooms.txt";
};

TEST_F(RoomLabelsFile, ReadsRanges) {
  const auto labels =
      read("# first last room visit\r\n\r\n0  19\tcorridor 1 # dark\r\n20 42 living room 2");
  ASSERT_OK(labels);
  EXPECT_THAT(labels->ranges(),
              ElementsAre(RoomRange{0, 19, "corridor", 1}, RoomRange{20, 42, "living room", 2}));
}

TEST_F(RoomLabelsFile, GivesBackWhatWasWritten) {
  const auto labels =
      RoomLabels::from_ranges({{0, 3, "living room", 1}, {7, 7, "bath", 1}, {8, 20, "bath", 2}});
  ASSERT_OK(labels);
  ASSERT_OK(labels->write(path_));
  EXPECT_EQ(RoomLabels::read(path_)->ranges(), labels->ranges());
}

TEST_F(RoomLabelsFile, NamesTheLineThatIsWrong) {
  EXPECT_ERROR(RoomLabels::read(folder_ / "none.txt"), "none.txt");
  EXPECT_ERROR(read("# nothing\n"), "names no room");
  EXPECT_ERROR(read("#\n0 19 corridor\n"), line(2) + ": 3 values");
  EXPECT_ERROR(read("-1 19 corridor 1\n"), "first_frame = '-1'");
  EXPECT_ERROR(read("0 x corridor 1\n"), "last_frame = 'x'");
  EXPECT_ERROR(read("0 9 corridor one\n"), "visit = 'one'");
  EXPECT_ERROR(read("0 9 corridor 0\n"), "visits are numbered from 1");
  EXPECT_ERROR(read("9 0 corridor 1\n"),
               line(1) + ": the range 9 to 0 of 'corridor' runs backwards");
  EXPECT_ERROR(read("0 9 a 1\n9 12 b 1\n"), line(2) + ": the range 9 to 12 of 'b' overlaps");
  EXPECT_ERROR(read("10 19 a 1\n0 5 b 1\n"), "stands after");
  EXPECT_ERROR(read("0 9 ki\xfc"
                    "che 1\n"),
               line(1) + ": the name of the room is not UTF-8");
}

TEST(RoomLabels, RefusesRangesThatMakeNoSense) {
  EXPECT_ERROR(RoomLabels::from_ranges({{0, 3, "", 1}}), "no name for a room");
  EXPECT_ERROR(RoomLabels::from_ranges({{0, 3, "two  blanks", 1}}), "no name for a room");
  EXPECT_ERROR(RoomLabels::from_ranges({{0, 3, "#1", 1}}), "no name for a room");
  EXPECT_ERROR(RoomLabels::from_ranges({{0, 3, "a\nb", 1}}), "no name for a room");
  EXPECT_ERROR(RoomLabels::from_ranges({{0, 3, "a", 1}, {3, 4, "b", 1}}), "overlaps");
  EXPECT_OK(RoomLabels::from_ranges({}));
}

TEST(RoomLabels, FindsTheRoomOfAFrame) {
  const RoomLabels labels =
      RoomLabels::from_ranges({{2, 4, "hall", 1}, {5, 9, "bath", 1}, {20, 20, "hall", 2}}).value();
  EXPECT_EQ(labels.find(1), nullptr);
  EXPECT_EQ(labels.find(2)->room, "hall");
  EXPECT_EQ(labels.find(4)->room, "hall");
  EXPECT_EQ(labels.find(5)->room, "bath");
  EXPECT_EQ(labels.find(10), nullptr);
  EXPECT_EQ(labels.find(20)->stay, 2);
  EXPECT_EQ(labels.find(21), nullptr);
  EXPECT_EQ(RoomLabels().find(0), nullptr);
}

TEST(RoomLabels, CountsTheFramesToTheBoundary) {
  const RoomLabels labels = RoomLabels::from_ranges({{2, 8, "hall", 1}}).value();
  EXPECT_EQ(labels.frames_to_boundary(2), 0U);
  EXPECT_EQ(labels.frames_to_boundary(4), 2U);
  EXPECT_EQ(labels.frames_to_boundary(5), 3U);
  EXPECT_EQ(labels.frames_to_boundary(8), 0U);
}

TEST(RoomLabels, ReadsTheRealWalk) {
  const auto walk = roomwise::testing::find_data("office_walk");
  ROOMWISE_REQUIRE_FILE(walk);
  const auto labels = RoomLabels::read(*walk / "rooms.txt");
  ASSERT_OK(labels);
  EXPECT_EQ(labels->ranges().size(), 13U);
  std::size_t away_from_boundaries = 0;
  for (std::uint64_t frame = 0; frame < 373; ++frame) {
    ASSERT_NE(labels->find(frame), nullptr) << frame;
    if (labels->frames_to_boundary(frame) >= 3) ++away_from_boundaries;
  }
  EXPECT_EQ(away_from_boundaries, 373U - 13 * 6);
}

}  // namespace
}  // namespace roomwise::recording
