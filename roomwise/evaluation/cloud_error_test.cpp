#include "roomwise/evaluation/cloud_error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/random.h"
#include "roomwise/base/testing.h"

namespace roomwise::evaluation {
namespace {

// A wall in the plane x = `x`, a point every centimetre.
std::vector<Eigen::Vector3f> wall(float x) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 100; ++i) {
    for (int j = 0; j < 100; ++j)
      points.emplace_back(x, -0.5F + 0.01F * static_cast<float>(i), 0.01F * static_cast<float>(j));
  }
  return points;
}

TEST(CloudError, IsTheDistanceToTheSurface) {
  const auto error = cloud_error(wall(0), wall(0.03F));
  ASSERT_OK(error);
  EXPECT_EQ(error->points, 10'000U);
  EXPECT_NEAR(error->distance_m.median, 0.03, 1e-6);
  EXPECT_EQ(error->within_1cm, 0);
  EXPECT_EQ(error->within_5cm, 1);
  EXPECT_EQ(error->far_points, 0U);
  EXPECT_EQ(cloud_error(wall(0), wall(0))->distance_m.max, 0);
}

TEST(CloudError, AgreesWithALookAtEveryPair) {
  RandomStream random(1);
  const auto cloud = [&](int count) {
    std::vector<Eigen::Vector3f> points;
    for (int i = 0; i < count; ++i) {
      points.emplace_back(static_cast<float>(random.uniform() - 0.5),
                          static_cast<float>(random.uniform() - 0.5),
                          static_cast<float>(random.uniform() - 0.5));
    }
    return points;
  };
  const auto truth = cloud(300);
  for (const Eigen::Vector3f& point : cloud(100)) {
    double least_m = 1e9;
    for (const Eigen::Vector3f& other : truth)
      least_m = std::min(least_m, static_cast<double>((other - point).norm()));
    EXPECT_NEAR(cloud_error(truth, std::vector{point}, 2.0)->distance_m.max, least_m, 1e-6);
  }
}

TEST(CloudError, CountsWhatHasNoSurfaceNearIt) {
  const std::vector<Eigen::Vector3f> ghost{{2, 0, 0}, {0, 0, 0}};
  const auto error = cloud_error(wall(0), ghost, 0.5);
  ASSERT_OK(error);
  EXPECT_EQ(error->far_points, 1U);
  EXPECT_EQ(error->within_1cm, 0.5);
  EXPECT_ERROR(cloud_error({}, ghost), "of the truth");
  EXPECT_ERROR(cloud_error(ghost, {}), "of the map");
}

}  // namespace
}  // namespace roomwise::evaluation
