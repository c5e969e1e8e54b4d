#include "roomwise/evaluation/statistics/score_ranking.h"

#include <gtest/gtest.h>

namespace roomwise::evaluation {
namespace {

TEST(AreaUnderRoc, CountsPairsThatAreInOrder) {
  EXPECT_DOUBLE_EQ(area_under_roc(std::vector{3.0, 4.0}, std::vector{1.0, 2.0}), 1);
  EXPECT_DOUBLE_EQ(area_under_roc(std::vector{1.0, 2.0}, std::vector{3.0, 4.0}), 0);
  // Of the six pairs (1, 0), (1, 2), (1, 2), (3, 0), (3, 2), (3, 2) two are out of order.
  EXPECT_DOUBLE_EQ(area_under_roc(std::vector{1.0, 3.0}, std::vector{2.0, 0.0, 2.0}), 4.0 / 6);
}

TEST(AreaUnderRoc, TiesCountHalf) {
  EXPECT_DOUBLE_EQ(area_under_roc(std::vector{1.0}, std::vector{1.0}), 0.5);
  EXPECT_DOUBLE_EQ(area_under_roc(std::vector{1.0, 2.0}, std::vector{1.0, 0.0}), 3.5 / 4);
}

TEST(AreaUnderRoc, TellsNothingWithoutBothKinds) {
  EXPECT_DOUBLE_EQ(area_under_roc({}, std::vector{1.0}), 0.5);
  EXPECT_DOUBLE_EQ(area_under_roc(std::vector{1.0}, {}), 0.5);
}

TEST(PrecisionAgainstCoverage, GoesFromTheSurestAnswerToAll) {
  const auto points =
      precision_against_coverage({{0.5, false}, {0.9, true}, {0.7, true}, {0.5, true}});
  ASSERT_EQ(points.size(), 3U) << "equal scores are answered together";
  EXPECT_DOUBLE_EQ(points[0].threshold, 0.9);
  EXPECT_DOUBLE_EQ(points[0].coverage, 0.25);
  EXPECT_DOUBLE_EQ(points[0].precision, 1);
  EXPECT_DOUBLE_EQ(points[1].coverage, 0.5);
  EXPECT_DOUBLE_EQ(points[2].coverage, 1);
  EXPECT_DOUBLE_EQ(points[2].precision, 0.75);
  EXPECT_TRUE(precision_against_coverage({}).empty());
}

}  // namespace
}  // namespace roomwise::evaluation
