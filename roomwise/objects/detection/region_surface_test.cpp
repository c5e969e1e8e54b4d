#include "roomwise/objects/detection/region_surface.h"

#include <gtest/gtest.h>
#include <Eigen/Geometry>

namespace roomwise::objects {
namespace {

const geometry::PinholeCamera kCamera = geometry::camera_preset("kinect-v1").value();
const network::PixelBox kRegionBox{220, 140, 420, 340};

// A wall at 3 m; before it, within the box but for a rim, a thing at 2 m.
image::DepthImage thing_before_wall() {
  image::DepthImage depth(640, 480, 3000);
  for (int y = 160; y < 320; ++y) {
    for (int x = 240; x < 400; ++x) depth.at(x, y) = 2000;
  }
  return depth;
}

float max_range_m(const DetectionSurface& surface) {
  float farthest = 0;
  for (const Eigen::Vector3f& point : surface.points) farthest = std::max(farthest, point.z());
  return farthest;
}

TEST(DetectionSurface, LeavesTheBackgroundOut) {
  const DetectionSurface surface = region_surface(thing_before_wall(), kCamera, kRegionBox);
  ASSERT_GT(surface.points.size(), 100U);
  EXPECT_LT(max_range_m(surface), 2.01F);
  EXPECT_NEAR(surface.share, 0.64F, 0.04F);
  EXPECT_EQ(surface.measured, 1);
  Eigen::AlignedBox3f extent;
  for (const Eigen::Vector3f& point : surface.points) {
    extent.extend(point);
    const Eigen::Vector2d pixel = kCamera.project(point.cast<double>());
    EXPECT_TRUE(pixel.x() > 239 && pixel.x() < 401 && pixel.y() > 159 && pixel.y() < 321);
  }
  EXPECT_NEAR(static_cast<double>(extent.sizes().x()), 160 * 2 / kCamera.fx, 0.04);
}

TEST(SurfaceWithin, HoldsWhatLiesInTheBoxInSpace) {
  const image::DepthImage depth = thing_before_wall();
  const Eigen::Vector3d middle = kCamera.unproject(Eigen::Vector2d(319.5, 239.5), 2.1);
  const geometry::OrientedBox thing{{Eigen::Quaterniond::Identity(), middle}, {0.4, 0.4, 0.3}};
  const DetectionSurface surface = surface_within(depth, kCamera, kRegionBox, thing);
  ASSERT_GT(surface.points.size(), 50U);
  for (const Eigen::Vector3f& point : surface.points) {
    EXPECT_LT(thing.distance_m(point.cast<double>()), 0.05);
  }
  EXPECT_GT(surface.share, 0.2F);
  EXPECT_LT(surface.share, 0.64F) << "the box is smaller than the thing";
  const geometry::OrientedBox wall{{Eigen::Quaterniond::Identity(), {middle.x(), middle.y(), 3}},
                                   {4, 4, 0.1}};
  EXPECT_GT(max_range_m(surface_within(depth, kCamera, kRegionBox, wall)), 2.99F);
  const geometry::OrientedBox nowhere{{Eigen::Quaterniond::Identity(), {0, 0, 1}}, {0.1, 0.1, 0.1}};
  EXPECT_TRUE(surface_within(depth, kCamera, kRegionBox, nowhere).points.empty());
  EXPECT_TRUE(
      surface_within(image::DepthImage(640, 480), kCamera, kRegionBox, thing).points.empty());
}

TEST(DetectionSurface, LeavesOutWhatStandsBefore) {
  image::DepthImage depth = thing_before_wall();
  for (int y = 0; y < 480; ++y) {
    for (int x = 380; x < 480; ++x) depth.at(x, y) = 900;  // a door post
  }
  const DetectionSurface surface = region_surface(depth, kCamera, kRegionBox);
  ASSERT_GT(surface.points.size(), 100U);
  for (const Eigen::Vector3f& point : surface.points) EXPECT_NEAR(point.z(), 2, 0.01);
}

TEST(DetectionSurface, FollowsASlantedSurface) {
  image::DepthImage depth(640, 480, 4500);
  for (int y = 160; y < 320; ++y) {
    for (int x = 240; x < 400; ++x)
      depth.at(x, y) = static_cast<std::uint16_t>(1500 + 6 * (x - 240));
  }
  const DetectionSurface surface = region_surface(depth, kCamera, kRegionBox);
  EXPECT_GT(max_range_m(surface), 2.4F);
  EXPECT_LT(max_range_m(surface), 2.5F);
}

TEST(DetectionSurface, IsEmptyWithoutDepth) {
  EXPECT_TRUE(region_surface(image::DepthImage(640, 480, 0), kCamera, kRegionBox).points.empty());
  EXPECT_TRUE(region_surface(thing_before_wall(), kCamera, {300, 300, 300, 300}).points.empty());
  EXPECT_TRUE(region_surface(thing_before_wall(), kCamera, {-90, -90, -10, -10}).points.empty());
}

TEST(CoarseDepth, IsTheMedianOfWhatWasMeasured) {
  image::DepthImage depth(64, 48, 0);
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 8; ++x) depth.at(x, y) = x < 2 ? 500 : 2000;
  }
  depth.at(8, 0) = 700;  // too few there
  const image::DepthImage coarse = coarse_depth(depth);
  EXPECT_EQ(coarse.width(), 8);
  EXPECT_EQ(coarse.height(), 6);
  EXPECT_EQ(coarse.at(0, 0), 2000);
  EXPECT_EQ(coarse.at(1, 0), 0);
}

}  // namespace
}  // namespace roomwise::objects
