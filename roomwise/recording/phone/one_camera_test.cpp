#include "roomwise/recording/phone/one_camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace roomwise::recording {
namespace {

using geometry::PinholeCamera;

// A wall, the ground plane or any other that a camera sees: normal . point = 1 in camera axes.
image::DepthImage plane(const PinholeCamera& camera, const Eigen::Vector3d& normal) {
  image::DepthImage depth(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector3d ray = camera.unproject_undistorted({x, y}, 1);
      depth.at(x, y) = static_cast<std::uint16_t>(std::lround(1000 / normal.dot(ray)));
    }
  }
  return depth;
}

const PinholeCamera kSmall{210, 211, 126, 97, 256, 192, {}, 1000};

TEST(OneCamera, KeepsWhatAPixelSeesInAnotherSize) {
  const PinholeCamera large = in_size(kSmall, 640, 480);
  const Eigen::Vector3d corner(-1, -0.7, 2);
  const Eigen::Vector2d before = kSmall.project(corner), after = large.project(corner);
  EXPECT_NEAR((before.x() + 0.5) / kSmall.width, (after.x() + 0.5) / large.width, 1e-12);
  EXPECT_NEAR((before.y() + 0.5) / kSmall.height, (after.y() + 0.5) / large.height, 1e-12);
}

TEST(OneCamera, MeasuresDepthAtEveryFewPixelsOfThePicture) {
  const PinholeCamera picture = in_size(kSmall, 1920, 1440);
  const PinholeCamera depth = depth_camera(picture, 256, 192);
  const Eigen::Vector3d point = picture.unproject({750, 75}, 2);
  EXPECT_LT((depth.project(point) - Eigen::Vector2d(100, 10)).norm(), 1e-9);
}

TEST(OneCamera, TellsPicturesOfAnotherShapeButForRounding) {
  PinholeCamera camera = kSmall;
  camera.width = 1921;
  camera.height = 1439;
  EXPECT_TRUE(has_shape_of(camera, 256, 192));
  EXPECT_TRUE(has_shape_of(camera, 257, 192));
  PinholeCamera small = camera;
  small.width = 320;
  small.height = 239;
  EXPECT_TRUE(has_shape_of(small, 640, 480));
  EXPECT_FALSE(has_shape_of(camera, 259, 192));
  EXPECT_FALSE(has_shape_of(camera, 192, 256));
  EXPECT_FALSE(has_shape_of(camera, 256, 144));
}

TEST(OneCamera, TakesTheSizeOfMost) {
  const std::vector<PictureSize> sizes{{8, 8}, {64, 48}, {64, 48}};
  EXPECT_EQ(first_of_most(sizes), 1U);
  EXPECT_EQ(first_of_most(std::span(sizes).first(2)), 0U);
}

TEST(OneCamera, TakesTheMedianAndKeepsTheShape) {
  PinholeCamera near = kSmall, far = kSmall;
  near.fx = 100;
  far.fx = 215;
  const std::array cameras{near, far, kSmall};
  const PinholeCamera camera = common_camera(cameras, 128);
  EXPECT_EQ(camera.width, 128);
  EXPECT_EQ(camera.height, 96);
  EXPECT_DOUBLE_EQ(camera.fx, 105);
  EXPECT_EQ(common_camera(cameras, 640).width, 256) << "never larger than it is";
}

TEST(OneCamera, SeesAPlaneWhereItIsWithTheDepthsOfASmallerPicture) {
  PinholeCamera to = in_size(kSmall, 640, 480);
  to.fx *= 1.02;  // another focus
  to.fy *= 1.02;
  const Eigen::Vector3d floor(0.05, 0.4, 0.25);
  const auto seen = as_seen_by(plane(kSmall, floor), kSmall, to);
  const auto expected = plane(to, floor);
  for (int y = 4; y < to.height - 4; ++y) {
    for (int x = 4; x < to.width - 4; ++x) {
      ASSERT_NEAR(seen.at(x, y), expected.at(x, y), 1.5) << x << ", " << y;
    }
  }
}

TEST(OneCamera, PutsNothingBetweenTwoSurfaces) {
  image::DepthImage depth(256, 192, 1000);
  for (int y = 0; y < 192; ++y) {
    for (int x = 128; x < 256; ++x) depth.at(x, y) = 3000;
  }
  const auto seen = as_seen_by(depth, kSmall, in_size(kSmall, 640, 480));
  for (const std::uint16_t pixel : seen.pixels()) {
    ASSERT_THAT(pixel, ::testing::AnyOf(0, 1000, 3000));
  }
  EXPECT_EQ(seen.at(317, 240), 1000);
  EXPECT_EQ(seen.at(319, 240), 0);
  EXPECT_EQ(seen.at(322, 240), 3000);
}

TEST(OneCamera, InventsNoDepthWhereNothingWasMeasured) {
  image::DepthImage depth(256, 192, 1000);
  for (int y = 0; y < 192; ++y) depth.at(128, y) = 0;
  const auto seen = as_seen_by(depth, kSmall, in_size(kSmall, 640, 480));
  EXPECT_EQ(seen.at(317, 240), 1000);
  EXPECT_EQ(seen.at(321, 240), 0);
  EXPECT_EQ(seen.at(325, 240), 1000);
}

TEST(OneCamera, LeavesOutWhatTheOtherCameraDidNotSee) {
  PinholeCamera wide = kSmall;
  wide.fx /= 1.1;
  wide.fy /= 1.1;
  const auto seen = as_seen_by(image::DepthImage(256, 192, 1000), kSmall, wide);
  EXPECT_EQ(seen.at(2, 96), 0);
  EXPECT_EQ(seen.at(20, 96), 1000);
}

TEST(OneCamera, PutsColourWhereDepthIs) {
  // The same edge in a large picture and a small depth image.
  const PinholeCamera large = in_size(kSmall, 1920, 1440);
  image::ColorImage color(1920, 1440, {10, 10, 10});
  for (int y = 0; y < 1440; ++y) {
    for (int x = 960; x < 1920; ++x) color.at(x, y) = {200, 200, 200};
  }
  const auto seen = as_seen_by(color, large, in_size(kSmall, 640, 480));
  EXPECT_EQ(seen.at(319, 240).r, 10);
  EXPECT_EQ(seen.at(320, 240).r, 200);
  EXPECT_EQ(as_seen_by(color, large, large), color);
}

}  // namespace
}  // namespace roomwise::recording
