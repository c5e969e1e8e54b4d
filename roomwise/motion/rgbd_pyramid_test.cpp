#include "roomwise/motion/rgbd_pyramid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "roomwise/base/testing/testing.h"
#include "roomwise/motion/testing/test_scenes.h"

namespace roomwise::motion {
namespace {

// An ideal camera that measures depth in mm.
geometry::PinholeCamera camera_of(int width, int height) {
  geometry::PinholeCamera camera;
  camera.fx = camera.fy = width;
  camera.cx = 0.5 * (width - 1);
  camera.cy = 0.5 * (height - 1);
  camera.width = width;
  camera.height = height;
  return camera;
}

PyramidLevel shrink_once(const image::GrayImage& gray, const image::DepthImage& depth,
                         const geometry::PinholeCamera& camera, int shrink, double farthest_m = 7) {
  return make_rgbd_pyramid(gray, depth, camera,
                           {.shrink = shrink, .levels = 1, .farthest_m = farthest_m})
      .levels.at(0);
}

// The depth, in mm, of one pixel that covers 4 x 4 of these depths in mm.
int depth_of_block(const std::vector<int>& depths_mm, double farthest_m = 7) {
  image::DepthImage depth(4, 4);
  for (std::size_t i = 0; i < 16; ++i)
    depth.pixels()[i] = static_cast<std::uint16_t>(depths_mm.at(i));
  return shrink_once(image::GrayImage(4, 4, 100), depth, camera_of(4, 4), 4, farthest_m)
      .depth.at(0, 0);
}
std::vector<int> block(int count, int depth_mm, int others, int other_mm) {
  std::vector<int> depths(static_cast<std::size_t>(count), depth_mm);
  depths.insert(depths.end(), static_cast<std::size_t>(others), other_mm);
  return depths;
}

TEST(RgbdPyramid, BrightnessIsTheMeanOfABlock) {
  image::GrayImage gray(6, 4);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 6; ++x) gray.at(x, y) = static_cast<std::uint8_t>(10 * x + 3 * y);
  }
  const PyramidLevel level = shrink_once(gray, image::DepthImage(6, 4), camera_of(6, 4), 2);
  ASSERT_EQ(level.gray.width(), 3);
  ASSERT_EQ(level.gray.height(), 2);
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 3; ++x) {
      // The mean is the value at the block's middle, here 0.5 above a whole number: rounded up.
      EXPECT_EQ(level.gray.at(x, y), std::lround(10 * (2 * x + 0.5) + 3 * (2 * y + 0.5)))
          << x << ", " << y;
    }
  }
}

TEST(RgbdPyramid, WhatFillsNoBlockIsLeftOut) {
  const PyramidLevel level =
      shrink_once(image::GrayImage(11, 7, 50), image::DepthImage(11, 7, 900), camera_of(11, 7), 4);
  EXPECT_EQ(level.gray.width(), 2);
  EXPECT_EQ(level.gray.height(), 1);
  EXPECT_EQ(level.camera.width, 2);
  EXPECT_EQ(level.camera.height, 1);
  EXPECT_EQ(level.depth.at(1, 0), 900);
}

TEST(RgbdPyramid, DepthIsTheMeanOfTheMeasured) {
  EXPECT_EQ(depth_of_block(block(16, 1500, 0, 0)), 1500);
  EXPECT_EQ(depth_of_block(block(8, 1500, 8, 1510)), 1505);
  EXPECT_EQ(depth_of_block(block(10, 1500, 6, 0)), 1500) << "zeros are no measurements";
}

TEST(RgbdPyramid, DepthNeedsHalfTheBlock) {
  EXPECT_EQ(depth_of_block(block(8, 1500, 8, 0)), 1500);
  EXPECT_EQ(depth_of_block(block(7, 1500, 9, 0)), 0);
  EXPECT_EQ(depth_of_block(block(0, 0, 16, 0)), 0);
}

TEST(RgbdPyramid, DepthIsThatOfTheSurfaceThatFillsTheBlock) {
  EXPECT_EQ(depth_of_block(block(13, 1500, 3, 3000)), 1500) << "the background does not pull";
  EXPECT_EQ(depth_of_block(block(13, 3000, 3, 1500)), 3000) << "nor does the foreground";
}

TEST(RgbdPyramid, HasNoDepthWhereNearAndFarAreMixed) {
  EXPECT_EQ(depth_of_block(block(8, 1500, 8, 3000)), 0);
  EXPECT_EQ(depth_of_block(block(10, 1500, 6, 3000)), 0);
}

TEST(RgbdPyramid, LeavesOutWhatIsTooFar) {
  EXPECT_EQ(depth_of_block(block(16, 3999, 0, 0), 4), 3999);
  EXPECT_EQ(depth_of_block(block(16, 4001, 0, 0), 4), 0);
}

TEST(RgbdPyramid, DepthIsInMillimetresWhateverTheCameraHas) {
  geometry::PinholeCamera camera = camera_of(4, 4);
  camera.depth_units_per_metre = 5000;
  const PyramidLevel level =
      shrink_once(image::GrayImage(4, 4), image::DepthImage(4, 4, 6000), camera, 2);
  EXPECT_EQ(level.camera.depth_units_per_metre, 1000);
  EXPECT_EQ(level.depth.at(1, 1), 1200);
  // 1 unit = 2 m: more than 16 bits of mm are too far, not wrapped around.
  camera.depth_units_per_metre = 0.5;
  EXPECT_EQ(shrink_once(image::GrayImage(4, 4), image::DepthImage(4, 4, 40), camera, 2, 1000)
                .depth.at(0, 0),
            0);
}

TEST(RgbdPyramid, LevelsHalve) {
  const geometry::PinholeCamera& camera = testing::kCamera;
  const RgbdPyramid view =
      make_rgbd_pyramid(image::GrayImage(640, 480, 77), image::DepthImage(640, 480, 5000), camera);
  ASSERT_EQ(view.levels.size(), 3U);
  EXPECT_FALSE(view.empty());
  EXPECT_TRUE(RgbdPyramid().empty());
  int width = 160, height = 120;
  for (const PyramidLevel& level : view.levels) {
    EXPECT_EQ(level.gray.width(), width);
    EXPECT_EQ(level.gray.height(), height);
    EXPECT_EQ(level.depth.width(), width);
    EXPECT_EQ(level.camera.width, width);
    EXPECT_EQ(level.camera.height, height);
    EXPECT_EQ(level.gray.at(width - 1, height - 1), 77);
    EXPECT_EQ(level.depth.at(width - 1, height - 1), 1000);
    width /= 2;
    height /= 2;
  }
}

TEST(RgbdPyramid, EachLevelsCameraSeesAPointInTheSamePlace) {
  const geometry::PinholeCamera& camera = testing::kCamera;
  const RgbdPyramid view =
      make_rgbd_pyramid(image::GrayImage(640, 480), image::DepthImage(640, 480), camera);
  const Eigen::Vector3d point(0.3, -0.2, 1.7);
  int shrink = 4;
  for (const PyramidLevel& level : view.levels) {
    const Eigen::Vector2d middle = Eigen::Vector2d::Constant(0.5 * (shrink - 1));
    const Eigen::Vector2d expected = (camera.project_undistorted(point) - middle) / shrink;
    EXPECT_LT((level.camera.project(point) - expected).norm(), 1e-9) << shrink;
    shrink *= 2;
  }
}

// A spot drawn where the lens shows a point is found where the ideal camera of each level sees it.
TEST(RgbdPyramid, TakesOutTheLensDistortion) {
  const geometry::PinholeCamera camera = geometry::camera_preset("fr1").value();
  for (const Eigen::Vector2d& slope :
       {Eigen::Vector2d(-0.5, -0.38), Eigen::Vector2d(0.5, 0.36), Eigen::Vector2d(0.1, -0.3)}) {
    const Eigen::Vector3d point(slope.x(), slope.y(), 1);
    const Eigen::Vector2d place = camera.project(point);
    image::GrayImage gray(640, 480, 20);
    for (int y = 0; y < 480; ++y) {
      for (int x = 0; x < 640; ++x) {
        const double squared = (Eigen::Vector2d(x, y) - place).squaredNorm();
        gray.at(x, y) = static_cast<std::uint8_t>(20 + std::lround(200 * std::exp(-squared / 72)));
      }
    }
    const RgbdPyramid view = make_rgbd_pyramid(gray, image::DepthImage(640, 480, 5000), camera);
    const PyramidLevel& level = view.levels[0];
    EXPECT_TRUE(level.camera.distortion.is_none());
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();
    double weight = 0;
    const Eigen::Vector2d expected = level.camera.project(point);
    for (int y = 0; y < level.gray.height(); ++y) {
      for (int x = 0; x < level.gray.width(); ++x) {
        if ((Eigen::Vector2d(x, y) - expected).norm() > 8) continue;
        centre += (level.gray.at(x, y) - 20) * Eigen::Vector2d(x, y);
        weight += level.gray.at(x, y) - 20;
      }
    }
    ASSERT_GT(weight, 0);
    EXPECT_LT((centre / weight - expected).norm(), 0.15) << "small pixels";
    // So that the test means something: without undistortion it would be elsewhere.
    EXPECT_GT((camera.project_undistorted(point) - place).norm() / 4, slope.norm() > 0.5 ? 1 : 0.1);
  }
}

TEST(RgbdPyramid, MeasuresTheSameDepthThroughTheLens) {
  // A slanted plane: its depth varies from pixel to pixel, so that a shift would show.
  const geometry::PinholeCamera camera = geometry::camera_preset("fr1").value();
  const geometry::RigidTransform pose = testing::motion_by({0.2, 0.4, 0}, {0, 0, 0});
  const testing::Picture picture = testing::render(testing::wall(2), camera, pose);
  const RgbdPyramid view = make_rgbd_pyramid(picture.gray, picture.depth, camera);
  for (const PyramidLevel& level : view.levels) {
    int measured = 0;
    // At the border a small pixel may cover what is partly outside the picture.
    for (int y = 1; y + 1 < level.depth.height(); ++y) {
      for (int x = 1; x + 1 < level.depth.width(); ++x) {
        if (level.depth.at(x, y) == 0) continue;
        const Eigen::Vector3d ray =
            pose.rotation * level.camera.unproject_undistorted(Eigen::Vector2d(x, y), 1);
        ASSERT_NEAR(level.depth.at(x, y) * ray.z(), 2000, 10) << x << ", " << y;
        ++measured;
      }
    }
    EXPECT_GT(measured, 0.85 * level.depth.width() * level.depth.height());
  }
}

TEST(RgbdPyramidOptions, SaysWhichFieldIsWrong) {
  EXPECT_OK(RgbdPyramidOptions{}.validate());
  EXPECT_OK((RgbdPyramidOptions{.shrink = 8}.validate()));
  EXPECT_ERROR(RgbdPyramidOptions{.shrink = 0}.validate(), "shrink = 0");
  EXPECT_ERROR(RgbdPyramidOptions{.shrink = 9}.validate(), "shrink = 9");
  EXPECT_ERROR(RgbdPyramidOptions{.levels = 0}.validate(), "levels");
  EXPECT_ERROR(RgbdPyramidOptions{.farthest_m = NAN}.validate(), "farthest_m");
}

}  // namespace
}  // namespace roomwise::motion
