#include "roomwise/evaluation/drawing/top_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "roomwise/base/testing/testing.h"
#include "roomwise/geometry/rigid_transform.h"

namespace roomwise::evaluation {
namespace {

using Eigen::Vector3d;
using geometry::PointCloud;
using geometry::RigidTransform;

constexpr Rgb8 kFloor = {90, 60, 30};
constexpr Rgb8 kWall = {10, 20, 200};
constexpr Rgb8 kTable = {20, 200, 20};
constexpr Rgb8 kCeiling = {250, 0, 0};

// A room of 6 m x 3 m, z up: floor, the four walls, a ceiling at 2.5 m, and a table of 1 m x 1 m in
// the corner at the origin.
PointCloud room(const RigidTransform& world_from_room) {
  PointCloud cloud;
  const auto add = [&](double x, double y, double z, Rgb8 color) {
    cloud.add((world_from_room * Vector3d(x, y, z)).cast<float>(), color);
  };
  constexpr double kStep_m = 0.02;
  for (double x = 0; x <= 6; x += kStep_m) {
    for (double y = 0; y <= 3; y += kStep_m) {
      add(x, y, 0, kFloor);
      add(x, y, 2.5, kCeiling);
      if (x <= 1 && y <= 1) add(x, y, 0.8, kTable);
    }
  }
  for (double z = 0; z < 2.5; z += 0.1) {
    for (double x = 0; x <= 6; x += kStep_m) {
      add(x, 0, z, kWall);
      add(x, 3, z, kWall);
    }
    for (double y = 0; y <= 3; y += kStep_m) {
      add(0, y, z, kWall);
      add(6, y, z, kWall);
    }
  }
  return cloud;
}

const std::vector<Vector3d> kPlaces = {{1.5, 1.5, 1.4}, {3, 1.5, 1.4}, {5, 1.5, 1.4}};

struct Scene {
  PointCloud cloud;
  std::vector<Vector3d> cameras;
  Vector3d up;
};

Scene scene_in(const RigidTransform& world_from_room) {
  Scene scene{room(world_from_room), {}, world_from_room.rotation * Vector3d::UnitZ()};
  for (const Vector3d& place : kPlaces) scene.cameras.push_back(world_from_room * place);
  return scene;
}

RigidTransform any_frame() {
  geometry::Vector6d twist;
  twist << 1.9, 0.4, -0.8, 3, -2, 1;
  return RigidTransform::exp(twist);
}

Rgb8 color_at(const TopView& view, const Vector3d& point) {
  const Eigen::Vector2d px = view.to_px(point);
  return view.picture.at(static_cast<int>(px.x()), static_cast<int>(px.y()));
}

TEST(TopView, ShowsWhatLiesHighestUnderTheCeiling) {
  for (const RigidTransform& world_from_room : {RigidTransform(), any_frame()}) {
    const Scene scene = scene_in(world_from_room);
    const auto view = render_top_view(scene.cloud, scene.cameras, scene.up);
    ASSERT_OK(view);
    EXPECT_EQ(color_at(*view, world_from_room * Vector3d(4, 2, 0)), kFloor);
    EXPECT_EQ(color_at(*view, world_from_room * Vector3d(0.5, 0.5, 0)), kTable);
    EXPECT_EQ(color_at(*view, world_from_room * Vector3d(3, 0, 0)), kWall);
    EXPECT_EQ(std::ranges::count(view->picture.pixels(), kCeiling), 0);
  }
}

TEST(TopView, TurnsTheWallsToThePicturesSidesAndTheLongOneAcross) {
  const RigidTransform world_from_room = any_frame();
  const Scene scene = scene_in(world_from_room);
  const auto view = render_top_view(scene.cloud, scene.cameras, scene.up);
  ASSERT_OK(view);
  // 6 m and 3 m with 0.3 m of margin around them, 1200 px across.
  EXPECT_EQ(view->picture.width(), 1200);
  EXPECT_NEAR(view->picture.height(), 1200 * 3.6 / 6.6, 20);
  EXPECT_NEAR(view->pixels_per_metre, 1200 / 6.6, 3);
  const auto px = [&](double x, double y) {
    return view->to_px(world_from_room * Vector3d(x, y, 0));
  };
  EXPECT_NEAR(px(0, 0).y(), px(6, 0).y(), 0.02 * 1200);
  EXPECT_NEAR(px(0, 0).x(), px(0, 3).x(), 0.02 * 1200);
  // The walk begins on the left, and nothing is mirrored: from above, y lies to the left of x.
  EXPECT_LT(px(1.5, 1.5).x(), px(5, 1.5).x());
  EXPECT_GT(px(0, 0).y(), px(0, 3).y());
}

TEST(TopView, AWalkTheOtherWayTurnsThePicture) {
  const RigidTransform world_from_room = any_frame();
  Scene scene = scene_in(world_from_room);
  std::ranges::reverse(scene.cameras);
  const auto view = render_top_view(scene.cloud, scene.cameras, scene.up);
  ASSERT_OK(view);
  EXPECT_GT(view->to_px(world_from_room * Vector3d(0, 0, 0)).x(),
            view->to_px(world_from_room * Vector3d(6, 0, 0)).x());
}

TEST(TopView, AStrayPointDoesNotShrinkTheMapButEveryCameraIsInside) {
  Scene scene = scene_in(RigidTransform());
  scene.cloud.add({9e8f, 3, 0}, kWall);
  const auto view = render_top_view(scene.cloud, scene.cameras, scene.up);
  ASSERT_OK(view);
  EXPECT_NEAR(view->pixels_per_metre, 1200 / 6.6, 3);

  scene.cameras.push_back({12, 1, 1.4});
  const auto longer = render_top_view(scene.cloud, scene.cameras, scene.up);
  ASSERT_OK(longer);
  const Eigen::Vector2d px = longer->to_px(scene.cameras.back());
  EXPECT_TRUE(longer->picture.contains(static_cast<int>(px.x()), static_cast<int>(px.y())));
}

TEST(TopView, SaysWhatIsMissing) {
  const Scene scene = scene_in(RigidTransform());
  EXPECT_ERROR(render_top_view(scene.cloud, {}, scene.up), "no key-frame");
  EXPECT_ERROR(render_top_view({}, scene.cameras, scene.up), "no point");
  EXPECT_ERROR(render_top_view(scene.cloud, scene.cameras, scene.up, {.longer_side_px = 1}),
               "longer_side_px");
  EXPECT_ERROR(render_top_view(scene.cloud, scene.cameras, scene.up, {.point_size_m = 0}),
               "point_size_m");
}

}  // namespace
}  // namespace roomwise::evaluation
