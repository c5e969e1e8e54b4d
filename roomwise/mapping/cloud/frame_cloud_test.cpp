#include "roomwise/mapping/cloud/frame_cloud.h"

#include <gtest/gtest.h>

namespace roomwise::mapping {
namespace {

TEST(FrameCloudMaker, PutsEachPixelWhereItWasSeen) {
  const geometry::PinholeCamera camera = geometry::camera_preset("fr1").value();
  image::ColorImage color(640, 480, {1, 2, 3});
  image::DepthImage depth(640, 480, 0);
  depth.at(100, 50) = 7500;  // 1.5 m
  color.at(100, 50) = {200, 100, 50};
  depth.at(101, 50) = 7500;    // between the steps
  depth.at(200, 50) = 50'000;  // 10 m: too far
  const geometry::PointCloud cloud =
      FrameCloudMaker(camera, {.pixel_step = 2, .farthest_m = 5}).make(color, depth);
  ASSERT_EQ(cloud.size(), 1U);
  EXPECT_EQ(cloud.colors[0], (Rgb8{200, 100, 50}));
  EXPECT_NEAR(cloud.points[0].z(), 1.5F, 1e-6F);
  EXPECT_LT((camera.project(cloud.points[0].cast<double>()) - Eigen::Vector2d(100, 50)).norm(),
            1e-3);
}

}  // namespace
}  // namespace roomwise::mapping
