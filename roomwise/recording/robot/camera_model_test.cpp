#include "roomwise/recording/robot/camera_model.h"

#include <gmock/gmock.h>

#include "roomwise/base/testing/testing.h"

namespace roomwise::recording {
namespace {

CameraInfoMessage info_with(const std::string& model, std::vector<double> distortion) {
  CameraInfoMessage info;
  info.width = 640;
  info.height = 480;
  info.distortion_model = model;
  info.distortion = std::move(distortion);
  info.k = {500, 0, 320, 0, 510, 240, 0, 0, 1};
  info.p = {400, 0, 310, 0, 0, 410, 230, 0, 0, 0, 1, 0};
  return info;
}

TEST(CameraModel, BrownIsTakenAsItIs) {
  const auto camera = camera_of(info_with("plumb_bob", {0.1, -0.2, 0.001, 0.002, 0.05}), false);
  ASSERT_OK(camera);
  EXPECT_EQ(camera->fx, 500);
  EXPECT_EQ(camera->cy, 240);
  EXPECT_EQ(camera->distortion.p2, 0.002);
  EXPECT_EQ(camera->distortion.k3, 0.05);
}

TEST(CameraModel, ARectifiedImageHasAnotherCameraAndNoLens) {
  const auto camera = camera_of(info_with("plumb_bob", {0.1, 0, 0, 0, 0}), true);
  ASSERT_OK(camera);
  EXPECT_EQ(camera->fx, 400);
  EXPECT_EQ(camera->cx, 310);
  EXPECT_EQ(camera->fy, 410);
  EXPECT_TRUE(camera->distortion.is_none());
}

// Where the rational model of OpenCV shows a point.
Eigen::Vector2d rational(const std::vector<double>& c, double x, double y) {
  const double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
  const double radial =
      (1 + c[0] * r2 + c[1] * r4 + c[4] * r6) / (1 + c[5] * r2 + c[6] * r4 + c[7] * r6);
  return {500 * (x * radial + 2 * c[2] * x * y + c[3] * (r2 + 2 * x * x)) + 320,
          510 * (y * radial + c[2] * (r2 + 2 * y * y) + 2 * c[3] * x * y) + 240};
}

TEST(CameraModel, ARationalLensIsFittedToLessThanAPixel) {
  // An Azure Kinect's.
  const std::vector<double> lens{0.45, -2.6, 0.0006, -0.0003, 1.5, 0.33, -2.4, 1.45};
  const auto camera = camera_of(info_with("rational_polynomial", lens), false);
  ASSERT_OK(camera);
  for (const double x : {-0.6, 0.0, 0.3, 0.62}) {
    for (const double y : {-0.45, 0.1, 0.46}) {
      const Eigen::Vector2d seen = camera->project({x, y, 1});
      EXPECT_LT((seen - rational(lens, x, y)).norm(), 1) << x << ", " << y;
    }
  }
}

TEST(CameraModel, AnInverseLensIsTurnedAround) {
  const auto camera =
      camera_of(info_with("Inverse Brown Conrady", {-0.05, 0.06, 0.0007, 0.001, -0.02}), false);
  ASSERT_OK(camera);
  // The model says which point a pixel sees: (120, 90) from the middle.
  const double x = 120.0 / 500, y = 90.0 / 510, r2 = x * x + y * y;
  const double radial = 1 + r2 * (-0.05 + r2 * (0.06 + r2 * -0.02));
  const Eigen::Vector3d point(x * radial + 2 * 0.0007 * x * y + 0.001 * (r2 + 2 * x * x),
                              y * radial + 0.0007 * (r2 + 2 * y * y) + 2 * 0.001 * x * y, 1);
  EXPECT_LT((camera->project(point) - Eigen::Vector2d(440, 330)).norm(), 0.1);
}

TEST(CameraModel, ALensWithoutCoefficientsIsNone) {
  for (const char* model : {"", "Inverse Brown Conrady", "equidistant", "None"}) {
    const auto camera = camera_of(info_with(model, {0, 0, 0, 0, 0}), false);
    ASSERT_OK(camera);
    EXPECT_TRUE(camera->distortion.is_none());
  }
}

TEST(CameraModel, WhatIsNotReadIsSaid) {
  EXPECT_ERROR(camera_of(info_with("equidistant", {0.1, 0, 0, 0}), false), "'equidistant'");
  EXPECT_ERROR(camera_of(info_with("", {0.1}), false), "record the rectified images");
  EXPECT_ERROR(camera_of(info_with("rational_polynomial", {0, 0, 0, 0, 0, 3, 9, 50}), false),
               "px from");
  EXPECT_ERROR(camera_of(info_with("plumb_bob", {std::nan(""), 0, 0, 0, 0}), false), "no numbers");
  CameraInfoMessage info = info_with("plumb_bob", {});
  info.k[0] = 0;
  EXPECT_ERROR(camera_of(info, false), "fx = 0");
  info = info_with("plumb_bob", {});
  info.width = 4'000'000'000;
  EXPECT_ERROR(camera_of(info, false), "4000000000x480");
}

}  // namespace
}  // namespace roomwise::recording
