#include "roomwise/evaluation/errors/cloud_error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "roomwise/base/testing/testing.h"

namespace roomwise::evaluation {
namespace {

constexpr double kNothingNear = std::numeric_limits<double>::infinity();

TEST(CloudError, SumsUpTheDistancesToTheSurface) {
  const auto error = cloud_error(std::vector{0.0, 0.005, 0.04, 0.1});
  ASSERT_OK(error);
  EXPECT_EQ(error->points, 4U);
  EXPECT_EQ(error->far_points, 0U);
  EXPECT_EQ(error->within_1cm, 0.5);
  EXPECT_EQ(error->within_5cm, 0.75);
  EXPECT_NEAR(error->distance_m.median, 0.0225, 1e-12);
  EXPECT_NEAR(error->distance_m.max, 0.1, 1e-12);
}

TEST(CloudError, CountsGhostsApart) {
  const auto error = cloud_error(std::vector{kNothingNear, 0.0});
  ASSERT_OK(error);
  EXPECT_EQ(error->far_points, 1U);
  EXPECT_EQ(error->within_1cm, 0.5);
  EXPECT_EQ(error->distance_m.max, 0);
  EXPECT_ERROR(cloud_error({}), "no point");
}

}  // namespace
}  // namespace roomwise::evaluation
