#include "roomwise/evaluation/statistics/resampling.h"

#include <gtest/gtest.h>

namespace roomwise::evaluation {
namespace {

TEST(BlockedProportion, AddsItsBlocksUp) {
  BlockedProportion proportion;
  proportion.add(1, true);
  proportion.add(1, false);
  proportion.add(2, true);
  EXPECT_EQ(proportion.total(), (Proportion{2, 3}));
  EXPECT_EQ(proportion.blocks(), 2U);
}

TEST(BlockedProportion, FramesThatHangTogetherMakeTheIntervalWide) {
  // 100 frames, 90 right. In ten blocks of which one is all wrong, or each with one wrong frame.
  BlockedProportion together;
  BlockedProportion spread;
  for (std::uint64_t frame = 0; frame < 100; ++frame) {
    together.add(frame / 10, frame >= 10);
    spread.add(frame / 10, frame % 10 != 0);
  }
  EXPECT_EQ(together.total(), spread.total());
  const Interval wide = together.resampled_interval();
  EXPECT_LE(wide.low, 0.7);
  EXPECT_DOUBLE_EQ(wide.high, 1);
  const Interval narrow = spread.resampled_interval();
  EXPECT_DOUBLE_EQ(narrow.low, 0.9);
  EXPECT_DOUBLE_EQ(narrow.high, 0.9);
}

TEST(BlockedProportion, OneBlockSaysNothing) {
  BlockedProportion proportion;
  EXPECT_DOUBLE_EQ(proportion.resampled_interval().high, 1);
  for (int i = 0; i < 50; ++i) proportion.add(7, true);
  EXPECT_DOUBLE_EQ(proportion.resampled_interval().low, 0);
}

TEST(BlockedProportion, TheSameSeedGivesTheSameInterval) {
  BlockedProportion proportion;
  for (std::uint64_t frame = 0; frame < 60; ++frame) proportion.add(frame / 7, frame % 5 != 0);
  EXPECT_DOUBLE_EQ(proportion.resampled_interval(3).low, proportion.resampled_interval(3).low);
}

}  // namespace
}  // namespace roomwise::evaluation
