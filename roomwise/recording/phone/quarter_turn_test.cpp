#include "roomwise/recording/phone/quarter_turn.h"

#include <gtest/gtest.h>

#include <numbers>

namespace roomwise::recording {
namespace {

using geometry::PinholeCamera;
using geometry::RigidTransform;

PinholeCamera camera_on_its_side() {
  PinholeCamera camera;
  camera.fx = 500;
  camera.fy = 510;
  camera.cx = 310;
  camera.cy = 230;
  camera.width = 640;
  camera.height = 480;
  return camera;
}
const PinholeCamera kCamera = camera_on_its_side();
const Eigen::Vector3d kUp = Eigen::Vector3d::UnitY();

// Level, looking along the world's -z, y up; then turned about the optical axis to the right, as
// the hand does that holds it, and bent down.
RigidTransform pose(double to_right_rad, double down_rad = 0) {
  const Eigen::Quaterniond level(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
  return {level * Eigen::AngleAxisd(-down_rad, Eigen::Vector3d::UnitX()) *
              Eigen::AngleAxisd(to_right_rad, Eigen::Vector3d::UnitZ()),
          {1, 2, 3}};
}

TEST(QuarterTurn, StandsUprightByThePoses) {
  using std::numbers::pi;
  EXPECT_EQ(upright_turns({{0, pose(0)}}, kUp), 0);
  EXPECT_EQ(upright_turns({{0, pose(pi / 2)}}, kUp), 1)
      << "a camera turned to the right sees up at its left: its picture is turned to the right";
  EXPECT_EQ(upright_turns({{0, pose(pi)}}, kUp), 2);
  EXPECT_EQ(upright_turns({{0, pose(-pi / 2)}}, kUp), 3);
  EXPECT_EQ(upright_turns({{0, pose(pi / 2 - 0.7, 0.6)}}, kUp), 1) << "held askew";
}

TEST(QuarterTurn, GoesByMostPicturesThatTell) {
  using std::numbers::pi;
  const RigidTransform across = pose(pi / 2), at_floor = pose(0, 1.4);
  EXPECT_EQ(
      upright_turns({{0, across}, {1, at_floor}, {2, at_floor}, {3, across}, {4, pose(0)}}, kUp),
      1);
  EXPECT_FALSE(upright_turns({{0, at_floor}}, kUp));
  EXPECT_FALSE(upright_turns({}, kUp));
}

TEST(QuarterTurn, TurnsPictureCameraAndPoseAlike) {
  image::Image<int> picture(kCamera.width, kCamera.height, 0);
  const Eigen::Vector3d point(0.31, -0.42, 1.7);
  const Eigen::Vector2d pixel = kCamera.project(point);
  const auto x = static_cast<int>(std::lround(pixel.x()));
  const auto y = static_cast<int>(std::lround(pixel.y()));
  picture.at(x, y) = 7;
  for (int turns = 0; turns < 4; ++turns) {
    const image::Image<int> other = turned(picture, turns);
    const PinholeCamera camera = turned(kCamera, turns);
    ASSERT_EQ(other.width(), camera.width) << turns;
    ASSERT_EQ(other.height(), camera.height) << turns;
    const Eigen::Vector2d seen = camera.project(turned_from_camera(turns) * point);
    EXPECT_EQ(
        other.at(static_cast<int>(std::lround(seen.x())), static_cast<int>(std::lround(seen.y()))),
        7)
        << turns;
  }
}

TEST(QuarterTurn, FourAreNone) {
  image::Image<int> picture(3, 2);
  for (int i = 0; i < 6; ++i) picture.pixels()[static_cast<std::size_t>(i)] = i;
  for (int turns = 1; turns < 4; ++turns) {
    EXPECT_EQ(turned(turned(picture, turns), 4 - turns), picture) << turns;
    EXPECT_EQ(turned(turned(kCamera, turns), 4 - turns), kCamera) << turns;
  }
}

}  // namespace
}  // namespace roomwise::recording
