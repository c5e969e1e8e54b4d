#include "roomwise/evaluation/statistics/proportion.h"

#include <gtest/gtest.h>

namespace roomwise::evaluation {
namespace {

TEST(Proportion, CountsSuccesses) {
  Proportion proportion;
  EXPECT_EQ(proportion.value(), 0);
  for (const bool success : {true, true, false, true}) proportion.add(success);
  EXPECT_EQ(proportion, (Proportion{3, 4}));
  EXPECT_EQ(proportion.value(), 0.75);
}

TEST(Proportion, HasWilsonsInterval) {
  // 990 of 1000: the known interval 98.17 % to 99.46 %.
  const Interval known = Proportion{990, 1000}.wilson_interval();
  EXPECT_NEAR(known.low, 0.9817, 5e-5);
  EXPECT_NEAR(known.high, 0.9946, 5e-5);
  // With no success: 0 to z^2 / (n + z^2).
  const Interval none = Proportion{0, 10}.wilson_interval();
  EXPECT_NEAR(none.low, 0, 1e-12);
  EXPECT_NEAR(none.high, 3.8414588 / 13.8414588, 1e-7);
  const Interval all = Proportion{10, 10}.wilson_interval();
  EXPECT_NEAR(all.low, 1 - none.high, 1e-12);
  EXPECT_NEAR(all.high, 1, 1e-12);
}

TEST(Proportion, WithoutTrialsAnythingIsPossible) {
  const Interval interval = Proportion().wilson_interval();
  EXPECT_EQ(interval.low, 0);
  EXPECT_EQ(interval.high, 1);
}

}  // namespace
}  // namespace roomwise::evaluation
