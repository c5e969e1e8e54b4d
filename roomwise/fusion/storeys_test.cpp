#include "roomwise/fusion/storeys.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace roomwise::fusion {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

// A flight along x from x = 2 on: 14 steps of 18 cm and 27 cm, 1 m wide about y = 0, from a floor
// at z = 0 to one at z = 2.52.
constexpr int kSteps = 14;
constexpr double kRise_m = 0.18, kGoing_m = 0.27, kFoot_m = 2;
constexpr double kRun_m = (kSteps - 1) * kGoing_m;

class StoreysTest : public ::testing::Test {
 protected:
  void add(const Vector3d& place, const Vector3f& normal) {
    mesh_.vertices.push_back(place.cast<float>());
    mesh_.normals.push_back(normal);
  }
  void add_floor(double from_x, double to_x, double from_y, double to_y, double z) {
    for (double x = from_x; x < to_x; x += 0.02) {
      for (double y = from_y; y < to_y; y += 0.02) add({x, y, z}, Vector3f::UnitZ());
    }
  }
  void add_flight() {
    for (int step = 1; step < kSteps; ++step) {
      const double x = kFoot_m + (step - 1) * kGoing_m;
      add_floor(x, x + kGoing_m, -0.5, 0.5, step * kRise_m);
    }
  }
  // On the left of who climbs, so high over the nosings.
  void add_wall_beside(double y, double from_m, double to_m) {
    for (double x = kFoot_m; x < kFoot_m + kRun_m; x += 0.02) {
      const double nosing_m = ((x - kFoot_m) / kGoing_m + 1) * kRise_m;
      for (double over = from_m; over < to_m; over += 0.02) {
        add({x, y, nosing_m + over}, Vector3f(0, -1, 0));
      }
    }
  }
  void make_home() {
    add_floor(-4, kFoot_m, -1, 1, 0);
    add_flight();
    add_floor(kFoot_m + kRun_m, kFoot_m + kRun_m + 5, -1, 1, kSteps * kRise_m);
  }
  // With a camera 1.4 m over the feet.
  static CameraPath path_over(bool is_up) {
    CameraPath path;
    for (double x = -3.5; x < kFoot_m + kRun_m + 4; x += 0.1) {
      const double steps =
          std::clamp(std::floor((x - kFoot_m) / kGoing_m) + 1, 0.0, static_cast<double>(kSteps));
      path.emplace_back(x, 0.03 * std::sin(3 * x), steps * kRise_m + 1.4);
    }
    if (!is_up) std::ranges::reverse(path);
    return path;
  }

  TriangleMesh mesh_;
};

TEST_F(StoreysTest, AFlatHasOneAndNoStairs) {
  add_floor(-4, 4, -1, 1, 0);
  CameraPath path;
  for (double x = -3; x < 3; x += 0.1) path.emplace_back(x, 0, 1.4);
  const StoreysFound found = find_storeys(mesh_, std::array{path}).value();
  EXPECT_EQ(found.floors_m.size(), 1U);
  EXPECT_TRUE(found.stairs.empty());
  EXPECT_TRUE(find_storeys({}, {})->floors_m.empty());
}

TEST_F(StoreysTest, TheOnlyLevelThatWasWalkedIsToldFromAHallThatWasLeftAtOnce) {
  make_home();
  CameraPath path = path_over(true);
  EXPECT_EQ(only_level_m(find_storeys(mesh_, std::array{path}).value()), 0) << "two were walked";
  std::erase_if(path, [](const Vector3d& place) { return place.x() < kFoot_m - 1; });
  const StoreysFound found = find_storeys(mesh_, std::array{path}).value();
  EXPECT_EQ(found.floors_m.size(), 1U);
  EXPECT_NEAR(only_level_m(found), kSteps * kRise_m, 0.02);
  EXPECT_EQ(only_level_m({{0.9}, {}}), 0) << "who looks over a counter does not stand on it";
}

TEST_F(StoreysTest, StairsAreCountedAndMeasuredWhicheverWayTheyAreWalked) {
  make_home();
  for (const bool is_up : {true, false}) {
    const StoreysFound found = find_storeys(mesh_, std::array{path_over(is_up)}).value();
    ASSERT_EQ(found.floors_m.size(), 2U);
    EXPECT_NEAR(found.floors_m[0], 0, 0.01);
    EXPECT_NEAR(found.floors_m[1], kSteps * kRise_m, 0.01);
    ASSERT_EQ(found.stairs.size(), 1U);
    const Staircase& stairs = found.stairs[0];
    EXPECT_EQ(stairs.steps, kSteps);
    EXPECT_NEAR((stairs.foot_gravity - Vector2d(kFoot_m, 0)).norm(), 0, 0.1);
    EXPECT_NEAR((stairs.top_gravity - Vector2d(kFoot_m + kRun_m, 0)).norm(), 0, 0.1);
    EXPECT_NEAR(stairs.up_rad, 0, 0.05);
    EXPECT_NEAR(stairs.width_m, 1, 0.11);
    EXPECT_FALSE(stairs.has_left_rail || stairs.has_right_rail);
  }
}

TEST_F(StoreysTest, ARailIsToldFromAWallByWhatIsAboveIt) {
  make_home();
  add_wall_beside(0.5, 0.8, 0.95);   // a rail on the left
  add_wall_beside(-0.55, 0.0, 2.2);  // a wall on the right
  const StoreysFound found = find_storeys(mesh_, std::array{path_over(true)}).value();
  ASSERT_EQ(found.stairs.size(), 1U);
  EXPECT_TRUE(found.stairs[0].has_left_rail);
  EXPECT_FALSE(found.stairs[0].has_right_rail);
}

TEST_F(StoreysTest, ARampHasNoSteps) {
  add_floor(-4, kFoot_m, -1, 1, 0);
  for (double x = kFoot_m; x < kFoot_m + kRun_m; x += 0.02) {
    for (double y = -0.5; y < 0.5; y += 0.02) {
      add({x, y, kSteps * kRise_m * (x - kFoot_m) / kRun_m}, Vector3f::UnitZ());
    }
  }
  add_floor(kFoot_m + kRun_m, kFoot_m + kRun_m + 5, -1, 1, kSteps * kRise_m);
  const StoreysFound found = find_storeys(mesh_, std::array{path_over(true)}).value();
  ASSERT_EQ(found.stairs.size(), 1U);
  EXPECT_EQ(found.stairs[0].steps, 0);
}

TEST_F(StoreysTest, APlatformLowerThanAPersonIsNoStorey) {
  add_floor(-4, 0, -1, 1, 0);
  add_floor(0, 4, -1, 1, 1.0);
  CameraPath path;
  for (double x = -3; x < 3; x += 0.1) path.emplace_back(x, 0, x < 0 ? 1.4 : 2.4);
  EXPECT_EQ(find_storeys(mesh_, std::array{path})->floors_m.size(), 1U);
}

Storeys two_storeys() {
  Storey upper;
  upper.floor_m = 2.5;
  upper.plan_from_gravity = {10, 0};
  upper.plan_from_x_m = 5;
  Staircase stairs;
  stairs.foot_gravity = {2, 0};
  stairs.top_gravity = {5, 0};
  stairs.below_plan = {1.55, 0};
  stairs.above_plan = {15.45, 0};
  stairs.height_m = 2.5;
  stairs.width_m = 1;
  return Storeys({Storey{}, upper}, {stairs});
}

TEST(Storeys, OfOneChangeNothing) {
  const Vector3d point(1, 2, 3);
  EXPECT_EQ(Storeys().plan_from_gravity(point), point);
  EXPECT_EQ(Storeys().gravity_from_plan(point), point);
  EXPECT_EQ(Storeys().stairs_at({1, 2}), nullptr);
}

TEST(Storeys, AreDrawnSideBySide) {
  const Storeys storeys = two_storeys();
  EXPECT_EQ(storeys.plan_from_gravity({1, 2, 1.4}), Vector3d(1, 2, 1.4));
  EXPECT_EQ(storeys.plan_from_gravity({1, 2, 3.9}), Vector3d(11, 2, 1.4));
  EXPECT_EQ(storeys.gravity_from_plan({11, 2, 1.4}), Vector3d(1, 2, 3.9));
  EXPECT_EQ(storeys.at_plan({11, 2}), 1U);
}

TEST(Storeys, KnowWhoIsOnTheStairsAndWhoIsBeyondThem) {
  const Storeys storeys = two_storeys();
  const Staircase& stairs = storeys.stairs()[0];
  EXPECT_EQ(storeys.stairs_at({3, 0.2}), &stairs);
  EXPECT_EQ(storeys.stairs_at({14, 0.2}), &stairs);  // the upper half of the steps
  EXPECT_EQ(storeys.stairs_at({1.5, 0}), nullptr);
  EXPECT_EQ(storeys.stairs_at({3, 0.8}), nullptr);
  EXPECT_NEAR(storeys.beyond_m(stairs, true, {15.4, 0}), 0.4, 1e-9);
  EXPECT_NEAR(storeys.beyond_m(stairs, false, {1.5, 0}), 0.5, 1e-9);
  EXPECT_LT(storeys.beyond_m(stairs, false, {3, 0}), 0);
}

}  // namespace
}  // namespace roomwise::fusion
