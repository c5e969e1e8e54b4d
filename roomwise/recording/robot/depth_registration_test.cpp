#include "roomwise/recording/robot/depth_registration.h"

#include <gmock/gmock.h>

#include <numbers>

namespace roomwise::recording {
namespace {

using geometry::PinholeCamera;
using image::DepthImage;

PinholeCamera camera_with(double f, int width, int height) {
  PinholeCamera camera;
  camera.fx = camera.fy = f;
  camera.cx = (width - 1) / 2.0;
  camera.cy = (height - 1) / 2.0;
  camera.width = width;
  camera.height = height;
  return camera;
}

geometry::RigidTransform moved(double x, double y, double z) {
  return {Eigen::Quaterniond::Identity(), {x, y, z}};
}

TEST(DepthRegistration, TheSameCameraSeesTheSame) {
  const PinholeCamera camera = camera_with(50, 40, 30);
  DepthImage depth(40, 30, 1500);
  depth.at(7, 5) = 900;
  depth.at(0, 0) = 0;
  EXPECT_EQ(DepthRegistration(camera, camera, {}).apply(depth), depth);
}

TEST(DepthRegistration, AFinerPictureHasNoHolesBetweenMeasurements) {
  const DepthImage depth(40, 30, 2000);
  const auto registered =
      DepthRegistration(camera_with(50, 40, 30), camera_with(150, 120, 90), {}).apply(depth);
  EXPECT_EQ(registered, DepthImage(120, 90, 2000));
}

TEST(DepthRegistration, AShiftedCameraSeesAWallShifted) {
  // 0.1 m to the right of the depth camera, a wall at 2 m is 0.1 * 100 / 2 = 5 px further left.
  DepthImage depth(40, 30, 2000);
  for (int y = 0; y < 30; ++y) depth.at(20, y) = 2002;
  const auto registered =
      DepthRegistration(camera_with(100, 40, 30), camera_with(100, 40, 30), moved(-0.1, 0, 0))
          .apply(depth);
  EXPECT_EQ(registered.at(15, 10), 2002);
  EXPECT_EQ(registered.at(14, 10), 2000);
  EXPECT_EQ(registered.at(34, 10), 2000);
  EXPECT_EQ(registered.at(36, 10), 0) << "beyond what the depth camera saw";
}

TEST(DepthRegistration, WhatIsNearerHidesWhatIsBehind) {
  // A box at 1 m moves by 10 px, the wall at 2 m behind by 5.
  DepthImage depth(60, 30, 2000);
  for (int y = 0; y < 30; ++y) {
    for (int x = 30; x < 40; ++x) depth.at(x, y) = 1000;
  }
  const auto registered =
      DepthRegistration(camera_with(100, 60, 30), camera_with(100, 60, 30), moved(-0.1, 0, 0))
          .apply(depth);
  for (int x = 20; x < 30; ++x) EXPECT_EQ(registered.at(x, 15), 1000) << x;
  EXPECT_EQ(registered.at(19, 15), 2000);
  EXPECT_EQ(registered.at(32, 15), 0) << "hidden from the depth camera by the box";
  EXPECT_EQ(registered.at(36, 15), 2000);
}

TEST(DepthRegistration, DistanceIsAlongTheColourCamerasAxis) {
  const DepthImage depth(40, 30, 2000);
  const auto registered =
      DepthRegistration(camera_with(50, 40, 30), camera_with(50, 40, 30), moved(0, 0, 0.25))
          .apply(depth);
  EXPECT_EQ(registered.at(20, 15), 2250);
}

TEST(DepthRegistration, WhatLiesBehindTheColourCameraIsNotSeen) {
  const DepthImage depth(40, 30, 2000);
  const geometry::RigidTransform turned{
      Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitY())), {0, 0, 0}};
  EXPECT_EQ(
      DepthRegistration(camera_with(50, 40, 30), camera_with(50, 40, 30), turned).apply(depth),
      DepthImage(40, 30));
}

TEST(DepthRegistration, ASlantedSurfaceHasNoCracks) {
  DepthImage depth(80, 60);
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 80; ++x) depth.at(x, y) = static_cast<std::uint16_t>(1000 + 10 * x);
  }
  const auto registered =
      DepthRegistration(camera_with(100, 80, 60), camera_with(130, 104, 78), moved(0.03, 0, 0))
          .apply(depth);
  for (int x = 12; x < 90; ++x) EXPECT_NE(registered.at(x, 40), 0) << x;
}

TEST(DepthRegistration, TheColourLensBends) {
  PinholeCamera color = camera_with(50, 40, 30);
  color.distortion.k1 = 1;
  DepthImage depth(40, 30);
  depth.at(35, 15) = 2000;
  const auto registered = DepthRegistration(camera_with(50, 40, 30), color, {}).apply(depth);
  const Eigen::Vector2d seen = color.project(camera_with(50, 40, 30).unproject({35, 15}, 2));
  EXPECT_GT(seen.x(), 36);
  EXPECT_EQ(registered.at(static_cast<int>(std::lround(seen.x())),
                          static_cast<int>(std::lround(seen.y()))),
            2000);
}

}  // namespace
}  // namespace roomwise::recording
