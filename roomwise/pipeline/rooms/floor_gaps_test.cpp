#include "roomwise/pipeline/rooms/floor_gaps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/pipeline/testing/mapped_room.h"

namespace roomwise::pipeline {
namespace {

using ::testing::ElementsAre;
using FloorGapTest = testing::MappedRoom;

TEST_F(FloorGapTest, FloorOfAnotherStoreyIsNotSeenFromTheOneDrawnBesideIt) {
  // The loft, over the hall, is drawn two metres beside it; nobody filmed up there.
  fusion::Storey upper;
  upper.floor_m = 2.5;
  upper.plan_from_gravity = {5, 0};
  upper.plan_from_x_m = 4;
  fusion::GravityAlignedFrame frame;
  frame.storeys = fusion::Storeys({fusion::Storey{}, upper});
  image::Image<fusion::FloorCell> cells(80, 20, fusion::FloorCell::kFree);
  for (int row = 0; row < cells.height(); ++row) {
    for (int column = 30; column < 50; ++column)
      cells.at(column, row) = fusion::FloorCell::kUnknown;
  }
  const fusion::FloorGrid grid({0, 0}, 0.1, std::move(cells));
  std::vector<rooms::WalkedPath> walks(2);
  for (const double x : {0.5, 1.0, 1.5, 2.0, 2.5}) {
    walks[0].push_back({{x, 1}, "hall"});
    walks[1].push_back({{x + 5, 1}, "loft"});
  }
  auto layout = rooms::RoomLayout::make(grid, walks);
  ASSERT_OK(layout);
  home::Keyframe below;  // looks over all of the hall, and towards where the loft is drawn
  below.recording = 1;
  below.pose = {testing::looking_at({-3, 1, 1.4}, {1, 1, 1.4}), 0};
  const auto gaps =
      find_floor_gaps(*home_, {frame, grid, *std::move(layout)}, std::array{below}, {.near_m = 12});
  ASSERT_OK(gaps);
  std::vector<std::string> far;
  for (const FloorGap& gap : *gaps)
    if (!gap.is_unseen) far.push_back(gap.room);
  EXPECT_THAT(far, ElementsAre("loft"));
}

}  // namespace
}  // namespace roomwise::pipeline
