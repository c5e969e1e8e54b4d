#include "roomwise/pipeline/rooms/room_selection.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/testing/testing.h"

namespace roomwise::pipeline {
namespace {

using ::testing::ElementsAre;

TEST(ParseVisits, ReadsNumbersAndSpans) {
  EXPECT_THAT(parse_stays("1").value(), ElementsAre(StaySpan{1, 1}));
  EXPECT_THAT(parse_stays("2-").value(), ElementsAre(StaySpan{2, std::nullopt}));
  EXPECT_THAT(parse_stays("1-3,7").value(), ElementsAre(StaySpan{1, 3}, StaySpan{7, 7}));
  for (const char* text : {"", "0", "a", "3-1", "1,", "-2", "1--2", "1.5"}) {
    EXPECT_ERROR(parse_stays(text), "are no visits");
  }
}

TEST(RoomSelection, SelectsByStayAndRoom) {
  const RoomSelection all;
  EXPECT_TRUE(all.contains({0, 1, "hall", 5}));
  const RoomSelection some{{StaySpan{2, std::nullopt}}, {"hall"}};
  EXPECT_TRUE(some.contains({0, 1, "hall", 2}));
  EXPECT_FALSE(some.contains({0, 1, "hall", 1}));
  EXPECT_FALSE(some.contains({0, 1, "attic", 2}));
  const auto labels = recording::RoomLabels::from_ranges({{0, 1, "attic", 1}});
  EXPECT_ERROR(some.check_against(*labels), "'hall'");
}

}  // namespace
}  // namespace roomwise::pipeline
