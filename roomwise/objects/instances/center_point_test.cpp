#include "roomwise/objects/instances/center_point.h"

#include <gtest/gtest.h>

namespace roomwise::objects {
namespace {

const geometry::PinholeCamera kKinect = geometry::camera_preset("kinect-v1").value();

TEST(CenterPoint, IsWhereTheCentreLooks) {
  image::DepthImage depth(640, 480, 4000);
  for (int y = 236; y <= 244; ++y) {
    for (int x = 316; x <= 324; ++x) depth.at(x, y) = 2000;
  }
  const auto point = center_point(depth, kKinect);
  ASSERT_TRUE(point.has_value());
  EXPECT_NEAR(point->z(), 2.0, 1e-9);
  EXPECT_LT((kKinect.project(*point) - Eigen::Vector2d(320, 240)).norm(), 1e-6);
}

TEST(CenterPoint, IsAbsentWithoutDepth) {
  EXPECT_FALSE(center_point(image::DepthImage(640, 480, 0), kKinect).has_value());
  image::DepthImage speck(640, 480, 0);
  speck.at(320, 240) = 2000;
  EXPECT_FALSE(center_point(speck, kKinect).has_value());
}

}  // namespace
}  // namespace roomwise::objects
