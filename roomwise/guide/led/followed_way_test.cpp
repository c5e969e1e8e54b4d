#include "roomwise/guide/led/followed_way.h"

#include <gtest/gtest.h>

#include <numbers>

#include "roomwise/guide/places/surfaces.h"
#include "roomwise/guide/testing/drawn_floor.h"
#include "roomwise/guide/testing/test_times.h"

namespace roomwise::guide {
namespace {

using Eigen::Vector2d;
using fusion::FloorCell;

// In two rooms (drawn_floor.h), where a bed stands in the left one.
class FollowedWayTest : public ::testing::Test {
 protected:
  [[nodiscard]] static Goal bed() {
    Goal goal;
    goal.noun = {Noun::Kind::kThing, "bed"};
    goal.outline = Outline{{3.3, 1.45}, {0.98, 2.7}};
    goal.room = "bedroom";
    return goal;
  }
  [[nodiscard]] FollowedWay way_to(Goal goal, const Vector2d& from) const {
    FollowedWay way({&grid_, &layout_, layout_.doorways()}, std::move(goal), {});
    way.plan_from({.pose = Pose{from, 0, 0.02}}, floor_);
    return way;
  }
  [[nodiscard]] Goal kitchen() const {
    return Goal::of(*std::ranges::find(layout_.rooms(), "kitchen", &rooms::RoomExtent::name));
  }

  const fusion::FloorGrid grid_ =
      testing::two_rooms().fill({28, 1}, {38, 28}, FloorCell::kOccupied).grid();
  const rooms::RoomLayout layout_ = testing::layout_of_two_rooms(grid_);
  BarredFloor floor_{&grid_};
};

TEST_F(FollowedWayTest, ItsFirstLegEndsAtTheDoor) {
  FollowedWay way = way_to(kitchen(), {1, 3.45});
  ASSERT_TRUE(way.leads_to_goal());
  EXPECT_EQ(way.place_at_end()->name, "door");
  EXPECT_FALSE(way.is_last_leg());
  EXPECT_TRUE(way.goes_straight_on());
  const Pose before_door{{3, 3.45}, 0};
  EXPECT_NEAR(way.left_on_leg_m(before_door), 1.05, 0.1);
  EXPECT_GT(way.left_m(before_door), way.left_on_leg_m(before_door) + 0.3);
  way.take_next_leg();
  EXPECT_EQ(way.place_at_end()->name, "kitchen");
}

TEST_F(FollowedWayTest, WhatStandsInAnotherRoomIsNoLandmark) {
  KnownThing shelf;
  shelf.name = "bookcase";
  shelf.probability = 0.95;
  shelf.box_keyframe.size_m = {0.3, 0.6, 1.8};
  shelf.position_plan = Eigen::Vector3d(4.3, 2.9, 0.9);
  const Vector2d behind_the_wall(3.9, 2.9);
  const auto is_named = [&](const std::optional<std::string>& room) {
    shelf.room = room;
    const HomeMap map{&grid_, &layout_, layout_.doorways(), {&shelf, 1}};
    return nearest_sure_thing(behind_the_wall, kHand_m, map) != nullptr;
  };
  ASSERT_EQ(layout_.room_at(behind_the_wall), "bedroom");
  EXPECT_TRUE(is_named("bedroom"));
  EXPECT_FALSE(is_named("kitchen"));
  EXPECT_TRUE(is_named(std::nullopt)) << "where nobody knows of which it is";
}

TEST_F(FollowedWayTest, WhatIsAtTheLegsEndHasASideAndIsNotBehindThem) {
  KnownThing plant;
  plant.name = "plant";
  plant.probability = 0.95;
  plant.box_keyframe.size_m = {0.2, 0.2, 1};
  const auto told = [&](const Vector2d& from_end) {
    FollowedWay way({&grid_, &layout_, layout_.doorways(), {&plant, 1}}, kitchen(), {});
    way.plan_from({.pose = Pose{{2.2, 0.6}, 0, 0.02}}, floor_);  // up to a corner, then to the door
    EXPECT_EQ(way.leg().doorway, nullptr);
    const Vector2d place = way.leg().to + from_end.x() * way.leg().along() +
                           from_end.y() * Vector2d(-way.leg().along().y(), way.leg().along().x());
    plant.position_plan = Eigen::Vector3d(place.x(), place.y(), 0.5);
    const auto noun = way.place_at_end();
    return noun ? noun->name + way.side_at_end() : "nothing" + way.side_at_end();
  };
  EXPECT_EQ(told({0.5, 0}), "plant");
  EXPECT_EQ(told({0, 0.5}), "plant_left");
  EXPECT_EQ(told({0, -0.5}), "plant_right");
  EXPECT_EQ(told({-0.5, 0}), "nothing");
}

TEST_F(FollowedWayTest, ADoorAndTheGoalHaveNoSide) {
  KnownThing plant;
  plant.name = "plant";
  plant.probability = 0.95;
  plant.box_keyframe.size_m = {0.2, 0.2, 1};
  plant.position_plan = Eigen::Vector3d(3.9, 3.0, 0.5);
  FollowedWay way({&grid_, &layout_, layout_.doorways(), {&plant, 1}}, kitchen(), {});
  way.plan_from({.pose = Pose{{1, 3.45}, 0, 0.02}}, floor_);
  EXPECT_EQ(way.place_at_end()->name, "door");
  EXPECT_EQ(way.side_at_end(), "");
  way.take_next_leg();
  EXPECT_EQ(way.place_at_end()->name, "kitchen");
  EXPECT_EQ(way.side_at_end(), "");
}

TEST_F(FollowedWayTest, ToTheLeftIsPositive) {
  const FollowedWay way = way_to(kitchen(), {1, 3.45});
  EXPECT_NEAR(way.bearing_error_rad({{1, 3.45}, -0.5}), 0.5, 0.02);
  EXPECT_FALSE(way.is_off({{1.5, 3.4}, 0.1}));
  EXPECT_TRUE(way.is_off({{1.5, 3.4}, 0.7})) << "turned from it";
  EXPECT_TRUE(way.is_off({{1.5, 2.2}, std::atan2(1.25, 2.5)})) << "beside it";
}

TEST_F(FollowedWayTest, WhatWasFoundBarredIsGoneAround) {
  const FollowedWay straight = way_to(bed(), {1, 1.5});
  EXPECT_TRUE(straight.is_last_leg());
  floor_.bar_ahead({{1.2, 1.5}, 0}, 0.25, kNow);
  const FollowedWay around = way_to(bed(), {1, 1.5});
  EXPECT_TRUE(around.leads_to_goal());
  EXPECT_GT(around.planned_m(), straight.planned_m() + 0.05);
}

TEST_F(FollowedWayTest, OnePictureMayBeWrongThatOneIsThere) {
  FollowedWay way = way_to(bed(), {1, 1.5});
  const Pose there{{2.5, 1.5}, 0, 0.02};
  EXPECT_FALSE(way.has_arrived(there, false));
  EXPECT_FALSE(way.has_arrived({{1.5, 1.5}, 0}, false));
  EXPECT_FALSE(way.has_arrived(there, false));
  EXPECT_TRUE(way.has_arrived({{2.52, 1.5}, 0}, false)) << "by another one";
  EXPECT_TRUE(way.has_arrived(there, true)) << "who stands";
  EXPECT_TRUE(way.comes_to_rest(there));
  EXPECT_FALSE(way.comes_to_rest({{2.5, 1.5}, std::numbers::pi / 2})) << "it is beside them";
}

TEST_F(FollowedWayTest, WhatOneIsLedUpToIsInNobodysWay) {
  const FollowedWay way = way_to(bed(), {1, 1.5});
  EXPECT_TRUE(way.is_goal({2.8, 1.5}));
  EXPECT_FALSE(way.is_goal({1.5, 1.5}));
  EXPECT_FALSE(way_to(kitchen(), {1, 3.45}).is_goal({4.2, 3.45})) << "a room is walked into";
}

TEST_F(FollowedWayTest, UnseenOneGoesTwoStepsAtMostWhereNothingIs) {
  const Pose last{{1, 1.5}, 0, 0.02};
  const FollowedWay way = way_to(bed(), last.position_plan);
  EXPECT_NEAR(way.unseen_step_m(last, {}, floor_).value(), 1.05, 1e-9);
  EXPECT_TRUE(way.unseen_step_m(last, 1.5, floor_));
  EXPECT_FALSE(way.unseen_step_m(last, 1.2, floor_)) << "depth shows something";
  floor_.bar_ahead(last, 0.2, kNow);
  EXPECT_FALSE(way.unseen_step_m(last, {}, floor_)) << "somebody found something";
  EXPECT_FALSE(FollowedWay({&grid_}, kitchen(), {}).unseen_step_m(last, {}, floor_))
      << "nothing is planned";
}

TEST_F(FollowedWayTest, TheLastStepEndsBeforeTheThing) {
  const FollowedWay way = way_to(bed(), {1, 1.5});
  EXPECT_FALSE(way.is_last_step({{1.1, 1.5}, 0}));
  EXPECT_TRUE(way.is_last_step({{1.8, 1.5}, 0}));
  EXPECT_FALSE(way.is_last_step({{1.8, 1.5}, 1})) << "not straight on";
}

}  // namespace
}  // namespace roomwise::guide
