#include "roomwise/guide/way/plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "roomwise/base/testing/testing.h"
#include "roomwise/guide/places/home_map.h"
#include "roomwise/guide/testing/drawn_floor.h"
#include "roomwise/guide/way/legs.h"

namespace roomwise::guide {
namespace {

using Eigen::Vector2d;
using fusion::FloorCell;
using fusion::FloorGrid;
using ::testing::ElementsAre;
using testing::Floor;
using ::testing::IsEmpty;

Goal thing_at(const Vector2d& middle, const Vector2d& size_m,
              std::optional<std::string> room = {}) {
  Goal goal;
  goal.noun = {Noun::Kind::kThing, "bed"};
  goal.outline = Outline{middle, size_m};
  goal.room = std::move(room);
  return goal;
}

UserLocation standing_at(const Vector2d& place) {
  return {.pose = Pose{place, 0, 0.05}};
}

// Two rooms as drawn_floor.h has them, with what is drawn into them.
class TwoRoomsTest : public ::testing::Test {
 protected:
  explicit TwoRoomsTest(const Floor& floor = testing::two_rooms())
      : grid(floor.grid()), layout(testing::layout_of_two_rooms(grid)) {}
  void draw(const Floor& floor) {
    grid = floor.grid();
    layout = testing::layout_of_two_rooms(grid);
  }
  [[nodiscard]] Plan plan(const UserLocation& from, const Goal& goal) const {
    return plan_way({&grid, &layout, layout.doorways(), {}}, from, goal);
  }
  [[nodiscard]] Goal room(const std::string& name) const {
    return Goal::of(*std::ranges::find(layout.rooms(), name, &rooms::RoomExtent::name));
  }

  FloorGrid grid;
  rooms::RoomLayout layout;
};

TEST_F(TwoRoomsTest, TheWayToAThingBesideTheDoorEndsInItsRoomWithTheWholeBody) {
  draw(testing::two_rooms().fill({42, 25}, {45, 29}, FloorCell::kOccupied));
  const Plan way =
      plan(standing_at({1, 3.45}), thing_at({4.35, 2.7}, {0.3, 0.4}, std::string("kitchen")));
  ASSERT_EQ(way.status, PlanStatus::kComplete);
  const HomeMap map{&grid, &layout, layout.doorways(), {}};
  EXPECT_FALSE(is_well_inside(map, "kitchen", {4.2, 3.45})) << "in the door's frame";
  EXPECT_TRUE(is_well_inside(map, "kitchen", way.route.back())) << way.route.back().transpose();
}

TEST(OutlineTest, TellsTheNearestPointOfATurnedRectangle) {
  const Outline outline{{1, 1}, {2, 0.5}, std::numbers::pi / 2};  // 2 m along y
  EXPECT_NEAR((outline.nearest_to({3, 1.5}) - Vector2d(1.25, 1.5)).norm(), 0, 1e-9);
  EXPECT_NEAR(outline.distance_m({3, 1.5}), 1.75, 1e-9);
  EXPECT_EQ(outline.distance_m({1.1, 1.9}), 0);
}

// Its middle is 1.3 m from the next free floor, and beside it nobody fits.
TEST(PlanTest, ABedBetweenWallsIsReachedFromItsFreeSide) {
  Floor floor(60, 30);
  floor.fill({35, 5}, {59, 25}, FloorCell::kOccupied);  // a niche, all of it bed
  const FloorGrid grid = floor.grid();
  const HomeMap map{&grid, nullptr, {}, {}};
  const Plan plan = plan_way(map, standing_at({0.6, 0.6}), thing_at({4.7, 1.5}, {2.4, 2}));
  EXPECT_EQ(plan.status, PlanStatus::kComplete);
  EXPECT_FALSE(plan.is_narrow);
  EXPECT_NEAR(plan.route.back().x(), 3.15, 0.1);
  EXPECT_NEAR(plan.touch_plan.x(), 3.5, 1e-9);
}

TEST(PlanTest, WhereShouldersMustBeTurnedItSaysSo) {
  Floor floor(60, 30);
  floor.fill({30, 1}, {31, 29}, FloorCell::kOccupied).fill({30, 10}, {31, 15}, FloorCell::kFree);
  const FloorGrid grid = floor.grid();  // a gap of 0.5 m
  const HomeMap map{&grid, nullptr, {}, {}};
  const Plan plan = plan_way(map, standing_at({0.6, 0.6}), thing_at({5, 2}, {0.2, 0.2}));
  EXPECT_EQ(plan.status, PlanStatus::kComplete);
  EXPECT_TRUE(plan.is_narrow);
}

TEST(PlanTest, AWayHasAsManyLegsAsItNeeds) {
  Floor floor(100, 40);  // walls from both sides, one after the other
  for (int i = 0; i < 8; ++i) {
    const int x = 10 + 10 * i;
    floor.fill({x, i % 2 == 0 ? 1 : 10}, {x + 1, i % 2 == 0 ? 30 : 39}, FloorCell::kOccupied);
  }
  const FloorGrid grid = floor.grid();
  const HomeMap map{&grid, nullptr, {}, {}};
  const Plan plan = plan_way(map, standing_at({0.5, 0.5}), thing_at({9.5, 3.5}, {0.2, 0.2}));
  EXPECT_EQ(plan.status, PlanStatus::kComplete);
  EXPECT_GT(legs_of(plan.route, {}).size(), 8u);
}

TEST_F(TwoRoomsTest, AThingAtTheWallIsReachedInItsOwnRoom) {
  draw(testing::two_rooms().fill({32, 8}, {40, 16}, FloorCell::kOccupied));
  const Goal goal = thing_at({3.6, 1.2}, {0.8, 0.8}, "bedroom");
  const Plan plan = this->plan(standing_at({5, 1.2}), goal);
  EXPECT_EQ(plan.status, PlanStatus::kComplete);
  EXPECT_LT(plan.route.back().x(), 3.9);
  EXPECT_THAT(plan.rooms, IsEmpty());
}

TEST_F(TwoRoomsTest, ARoomIsReachedBeyondItsDoor) {
  const Plan plan = this->plan(standing_at({1, 1}), room("kitchen"));
  EXPECT_EQ(plan.status, PlanStatus::kComplete);
  EXPECT_EQ(layout.room_at(plan.route.back()), "kitchen");
  const double from_door_m = (plan.route.back() - layout.doorways()[0].middle_plan).norm();
  EXPECT_NEAR(from_door_m, 0.8, 0.15);
}

TEST_F(TwoRoomsTest, ADoorIsReachedFromWhereOneIs) {
  const Goal door = Goal::of(layout.doorways()[0]);
  for (const double x : {1.0, 7.0}) {
    const Plan plan = this->plan(standing_at({x, 1}), door);
    EXPECT_EQ(plan.status, PlanStatus::kComplete);
    EXPECT_LT(door.outline->distance_m(plan.route.back()), 0.5);
  }
}

// A hall lies behind the wall at whose end the door stands; one comes from there by the bedroom.
TEST(PlanTest, ADoorIsReachedFromOneOfItsRoomsAndThroughNoWall) {
  const FloorGrid grid = Floor(81, 80)
                             .fill({40, 1}, {41, 30}, FloorCell::kOccupied)
                             .fill({10, 39}, {80, 40}, FloorCell::kOccupied)
                             .grid();
  rooms::WalkedPath below, hall;
  for (double x = 0.6; x < 7.7; x += 0.25) {
    below.push_back({{x, 3.45}, x < 4 ? "bedroom" : "kitchen"});
    hall.push_back({{x, 5}, "hall"});
  }
  const auto layout = rooms::RoomLayout::make(grid, std::vector{below, hall}).value();
  const auto doorways = layout.doorways();
  const auto door = std::ranges::find_if(doorways, [](const rooms::Doorway& one) {
    return one.joins("bedroom") && one.joins("kitchen");
  });
  ASSERT_NE(door, doorways.end());
  const Plan plan =
      plan_way({&grid, &layout, doorways, {}}, standing_at({4.05, 4.3}), Goal::of(*door));
  EXPECT_EQ(plan.status, PlanStatus::kComplete);
  EXPECT_NE(layout.room_at(plan.route.back()), "hall");
}

// It stands in the wall between the rooms, which is along y.
TEST_F(TwoRoomsTest, ADoorIsAsWideAsItIsAndLiesAlongItsWall) {
  const Outline door = *Goal::of(layout.doorways()[0]).outline;
  EXPECT_NEAR(door.size_m.x(), 0.9, 0.11);
  EXPECT_EQ(door.size_m.y(), 0);
  EXPECT_NEAR(door.distance_m({3.5, 3.45}), 0.55, 0.11) << "before it";
  EXPECT_NEAR(door.distance_m({4.05, 3.1}), 0, 0.11) << "at its side";
  EXPECT_NEAR(door.nearest_to({4.05, 1}).y(), 3, 0.11);
}

TEST_F(TwoRoomsTest, WhereNoSafeWayIsKnownItEndsAsNearAsOneGets) {
  // Nobody ever saw the floor around the bed in the kitchen.
  draw(testing::two_rooms().fill({58, 1}, {80, 39}, FloorCell::kUnknown));
  const Goal goal = thing_at({7.3, 2}, {1, 1}, "kitchen");
  const Plan plan = this->plan(standing_at({1, 1}), goal);
  EXPECT_EQ(plan.status, PlanStatus::kPartial);
  EXPECT_NEAR(plan.route.back().x(), 5.75, 0.2);
  EXPECT_NEAR(plan.touch_plan.x(), 6.8, 1e-9);
  EXPECT_THAT(plan.rooms, IsEmpty());
  EXPECT_THAT(plan.because, ::testing::HasSubstr("no free floor"));
}

TEST_F(TwoRoomsTest, BehindADoorThatIsShutItEndsAtTheDoorAndTellsTheRooms) {
  draw(testing::two_rooms());
  const auto doorways = layout.doorways();
  const FloorGrid shut = testing::two_rooms().fill({40, 30}, {41, 39}, FloorCell::kOccupied).grid();
  const Goal goal = thing_at({4.6, 1}, {0.5, 0.5}, "kitchen");
  const Plan plan = plan_way({&shut, &layout, doorways, {}}, standing_at({1, 1}), goal);
  EXPECT_EQ(plan.status, PlanStatus::kPartial);
  EXPECT_LT((plan.route.back() - doorways[0].middle_plan).norm(), 0.6)
      << "and not at the wall before the goal";
  EXPECT_THAT(plan.rooms, ElementsAre("bedroom", "kitchen"));
}

TEST_F(TwoRoomsTest, WithoutAPlaceTheRoomsAreTold) {
  const Goal goal = thing_at({7, 2}, {1, 1}, "kitchen");
  const Plan plan = this->plan({.room = "bedroom"}, goal);
  EXPECT_EQ(plan.status, PlanStatus::kRoomsOnly);
  EXPECT_THAT(plan.rooms, ElementsAre("bedroom", "kitchen"));
  EXPECT_THAT(plan.route, IsEmpty());
  EXPECT_EQ(this->plan({.room = "kitchen"}, goal).status, PlanStatus::kRoomsOnly);
  EXPECT_EQ(this->plan({}, goal).status, PlanStatus::kNone);
  UserLocation unsure = standing_at({1, 1});
  unsure.pose->sigma_m = 2;
  EXPECT_EQ(this->plan(unsure, goal).status, PlanStatus::kNone);
  Goal unknown = goal;
  unknown.outline.reset();
  EXPECT_EQ(this->plan(standing_at({1, 1}), unknown).status, PlanStatus::kRoomsOnly);
}

TEST(LegsTest, DoorsAndOpeningsEndLegsAndOpenBordersDoNot) {
  rooms::Doorway door{
      .rooms = {"hall", "kitchen"}, .width_m = 0.9, .direction_rad = 1.5708, .is_framed = true};
  rooms::Doorway opening{
      .rooms = {"kitchen", "lounge"}, .width_m = 0.8, .direction_rad = 1.5708, .is_walked = true};
  rooms::Doorway border{.rooms = {"dining room", "lounge"}, .width_m = 3, .is_walked = true};
  door.middle_plan = {1, 0};
  opening.middle_plan = {3, 0};
  border.middle_plan = {5, 0};
  const std::vector doorways{border, opening, door};
  const auto legs = legs_of({{0, 0}, {7, 0}}, doorways);
  ASSERT_EQ(legs.size(), 3U);
  EXPECT_TRUE(legs[0].ends_at_door());
  EXPECT_FALSE(legs[1].ends_at_door());
  EXPECT_EQ(legs[1].doorway, &doorways[1]);
  EXPECT_NEAR(legs[1].to.x(), 3, 1e-9);
  EXPECT_EQ(legs[2].doorway, nullptr);
}

TEST(LegsTest, ADoorThatOneWalksPastEndsNone) {
  rooms::Doorway door{
      .rooms = {"hall", "kitchen"}, .width_m = 0.9, .direction_rad = 1.5708, .is_framed = true};
  door.middle_plan = {1, 0};
  const std::vector doorways{door};
  EXPECT_EQ(legs_of({{0.7, -2}, {0.7, 2}}, doorways).size(), 1U) << "along its wall";
  const auto ends = [&](const Route& route) {
    std::vector<double> ends_x;
    for (const Leg& leg : legs_of(route, doorways)) {
      if (leg.ends_at_door()) ends_x.push_back(leg.to.x());
    }
    return ends_x;
  };
  const auto at_the_door = ::testing::ElementsAre(::testing::DoubleNear(1, 1e-4));
  EXPECT_THAT(ends({{0, 0}, {2, 0}}), at_the_door);
  EXPECT_THAT(ends({{2, 0.2}, {0, -0.3}}), at_the_door);
  EXPECT_THAT(ends({{0, 0}, {1, 0}, {2, 1}}), at_the_door) << "a corner in it";
  EXPECT_THAT(ends({{2, 1}, {1, 0}, {0, 0}}), at_the_door);
  EXPECT_THAT(ends({{0, 1}, {2, 1}}), ::testing::IsEmpty()) << "beside it";
  std::vector said{door};
  said[0].width_m = 0;  // somebody says that it is there; nobody knows how its wall goes
  EXPECT_EQ(legs_of({{0.7, -2}, {0.7, 2}}, said).size(), 2U);
}

TEST(DoorsTest, BordersOfOpenAreasAreNoDoors) {
  rooms::Doorway open, door, wide;
  door.width_m = 0.9;
  door.is_framed = true;
  wide.width_m = 2.5;
  wide.is_framed = true;
  open.width_m = 0.5;
  open.is_walked = true;
  EXPECT_EQ(doors_of(std::vector{open, door, wide}).size(), 1U);
  door.width_m = 0;  // somebody says that it is there
  EXPECT_EQ(doors_of(std::vector{open, door, wide}).size(), 1U);
}

TEST(PlanTest, OptionsSayWhatIsWrong) {
  EXPECT_OK(PlanOptions{}.validate());
  EXPECT_ERROR(PlanOptions{.narrow_radius_m = 0.5}.validate(), "narrow_radius_m is 0.5");
  EXPECT_ERROR(PlanOptions{.arm_m = 0}.validate(), "arm_m 0");
}

}  // namespace
}  // namespace roomwise::guide
