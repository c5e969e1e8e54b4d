#include "roomwise/evaluation/statistics/coverage.h"

#include <gtest/gtest.h>

namespace roomwise::evaluation {
namespace {

TEST(Coverage, CountsEachAxisWithinOneAndTwoStandardDeviations) {
  Coverage coverage;
  coverage.add({0.05, -0.15, 0.3}, {0.1, 0.1, 0.1});
  EXPECT_EQ(coverage.one_sigma, (Proportion{1, 3}));
  EXPECT_EQ(coverage.two_sigma, (Proportion{2, 3}));
  Coverage both = coverage;
  both += coverage;
  EXPECT_EQ(both.two_sigma, (Proportion{4, 6}));
}

}  // namespace
}  // namespace roomwise::evaluation
