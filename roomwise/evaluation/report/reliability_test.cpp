#include "roomwise/evaluation/report/reliability.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace roomwise::evaluation {
namespace {

TEST(Reliability, SaysHowOftenWhatWasLikelyWasSo) {
  const std::vector<Forecast> forecasts{{0.1, false}, {0.7, true}, {0.7, true},
                                        {0.7, false}, {0.7, true}, {1, true}};
  const auto curve = reliability_curve(forecasts);
  ASSERT_EQ(curve.size(), 5U);
  EXPECT_EQ(curve[0].right, (Proportion{0, 1}));
  EXPECT_EQ(curve[3].right, (Proportion{3, 4}));
  EXPECT_NEAR(curve[3].mean, 0.7, 1e-12);
  EXPECT_EQ(curve[4].right, (Proportion{1, 1})) << "certainty is in the last one";
  EXPECT_NEAR(calibration_error(curve), (0.1 + 4 * 0.05 + 0) / 6, 1e-12);
}

TEST(Reliability, OfThingsWhatNeedNotBeFoundIsLeftOut) {
  const geometry::OrientedBox box{{Eigen::Quaterniond::Identity(), {0, 0, 0}}, {1, 1, 1}};
  const geometry::OrientedBox other{{Eigen::Quaterniond::Identity(), {9, 0, 0}}, {1, 1, 1}};
  const std::vector<TrueObject> truth{{"bed", box}, {"sofa", other, false}};
  const std::vector<FoundObject> found{
      {"bed", {0, 0, 0}}, {"bed", {0.3, 0, 0}}, {"sofa", {9, 0, 0}}, {"lamp", {4, 0, 0}}};
  const std::vector<double> probabilities{0.9, 0.8, 0.7, 0.6};
  const auto forecasts = forecasts_of(*object_errors(truth, found), truth, probabilities);
  ASSERT_EQ(forecasts.size(), 3U);
  EXPECT_TRUE(forecasts[0].is_right);
  EXPECT_EQ(forecasts[1].probability, 0.8) << "the bed once more";
  EXPECT_FALSE(forecasts[1].is_right);
  EXPECT_EQ(forecasts[2].probability, 0.6);
}

TEST(Reliability, OfNothingNothingIsOff) {
  EXPECT_EQ(calibration_error(reliability_curve({})), 0);
  EXPECT_THAT(reliability_table("Nothing", reliability_curve({})), ::testing::HasSubstr("–"));
}

}  // namespace
}  // namespace roomwise::evaluation
