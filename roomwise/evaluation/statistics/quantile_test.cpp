#include "roomwise/evaluation/statistics/quantile.h"

#include <gtest/gtest.h>

namespace roomwise::evaluation {
namespace {

TEST(MiddleAndRange, SaysTheMiddleOneAndTheRange) {
  EXPECT_EQ(middle_and_range({3, 1, 2}, 1), "2.0 (1.0 to 3.0)");
  EXPECT_EQ(middle_and_range({2, 2}, 0), "2") << "where all are the same, that alone";
}

}  // namespace
}  // namespace roomwise::evaluation
