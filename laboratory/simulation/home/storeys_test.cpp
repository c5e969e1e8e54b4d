#include "laboratory/simulation/home/storeys.h"

#include <gtest/gtest.h>

#include "laboratory/simulation/home/ground_truth.h"
#include "laboratory/simulation/home/home_checks.h"
#include "laboratory/simulation/home/home_geometry.h"
#include "laboratory/simulation/testing/made_up_furniture.h"
#include "laboratory/simulation/walk/walk.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::simulation {
namespace {

using Eigen::Vector2d;

HomeModel two_storeys(std::uint64_t seed) {
  HomeOptions options;
  options.seed = seed;
  options.storeys = 2;
  return generate_home(options, testing::made_up_furniture()).value();
}

class TwoStoreys : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(TwoStoreys, AreAHomeWithoutFaultsWhoseEveryRoomCanBeReached) {
  const HomeModel home = two_storeys(GetParam());
  for (const std::string& fault : find_faults(home)) ADD_FAILURE() << fault;
  ASSERT_EQ(home.storeys.size(), 2U);
  ASSERT_EQ(home.stairs.size(), 1U);
  EXPECT_EQ(home.rooms[home.stairs[0].lower_room].storey, 0U);
  EXPECT_EQ(home.rooms[home.stairs[0].upper_room].storey, 1U);
}

TEST_P(TwoStoreys, LieAboveOneAnotherInTheWorld) {
  const HomeModel plan = two_storeys(GetParam());
  const HomeModel world = in_world(plan);
  const Staircase& stairs = plan.stairs[0];
  for (const Room& room : world.rooms) {
    EXPECT_DOUBLE_EQ(room.floor_m, room.storey == 0 ? 0 : stairs.height_m()) << room.name;
  }
  // The opening that the stairs lead through is the same above and below.
  const auto& below = world.rooms[stairs.lower_room].open_ceiling;
  const auto& above = world.rooms[stairs.upper_room].open_floor;
  ASSERT_TRUE(below && above);
  EXPECT_NEAR((below->min - above->min).norm() + (below->max - above->max).norm(), 0, 1e-9);
}

TEST_P(TwoStoreys, AreWalkedOverTheStairsStepByStep) {
  const HomeModel home = two_storeys(GetParam());
  WalkOptions options;
  options.jitter = 0;
  options.frames_per_second = 10;
  const auto walk = plan_walk(home, options).value();
  const double height_m = home.stairs[0].height_m();
  double highest_m = 0;
  for (std::size_t i = 1; i < walk.size(); ++i) {
    const double here_m = walk[i].world_from_camera.translation.z() - options.camera_height_m;
    const double before_m = walk[i - 1].world_from_camera.translation.z() - options.camera_height_m;
    EXPECT_LT(std::abs(here_m - before_m), 0.09);
    highest_m = std::max(highest_m, here_m);
    EXPECT_EQ(home.rooms[walk[i].room].storey, here_m > height_m / 2 ? 1U : 0U);
  }
  EXPECT_NEAR(highest_m, height_m, 1e-9);
  EXPECT_NEAR(walk.back().world_from_camera.translation.z(), options.camera_height_m, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Seeds, TwoStoreys, ::testing::Values(1, 2, 3, 5, 212));

TEST(Storeys, AreInTheTruthAndReadBack) {
  const HomeModel home = two_storeys(3);
  const testing::ScratchFolder folder;
  ASSERT_OK(write_floor_plan(folder / "floorplan.json", home));
  const FloorPlanTruth truth = read_floor_plan(folder / "floorplan.json").value();
  ASSERT_EQ(truth.storeys.size(), 2U);
  ASSERT_EQ(truth.stairs.size(), 1U);
  EXPECT_EQ(truth.stairs[0].steps, home.stairs[0].steps);
  EXPECT_EQ(truth.stairs[0].upper_room, home.stairs[0].upper_room);
  EXPECT_EQ(truth.stairs[0].has_left_rail, home.stairs[0].has_left_rail);
  EXPECT_NE(truth.stairs[0].has_left_rail, truth.stairs[0].has_right_rail);
  EXPECT_NEAR(truth.storeys[1].world_from_plan.z(), home.stairs[0].height_m(), 1e-4);
}

TEST(Storeys, OfOneAreThePlanItself) {
  HomeOptions options;
  options.seed = 3;
  const HomeModel plan = generate_home(options, testing::made_up_furniture()).value();
  const HomeModel world = in_world(plan);
  ASSERT_EQ(world.objects.size(), plan.objects.size());
  for (std::size_t i = 0; i < plan.objects.size(); ++i) {
    EXPECT_EQ(world.objects[i].world_from_object.translation,
              plan.objects[i].world_from_object.translation);
  }
}

}  // namespace
}  // namespace roomwise::simulation
