#include "roomwise/rooms/layout/room_layout.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::rooms {
namespace {

using Eigen::Vector2d;
using fusion::FloorCell;
using fusion::FloorGrid;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Optional;

constexpr double kCell_m = 0.1;

// '.' is free, '#' occupied, ' ' unknown; the first row is the lowest. Cells of 0.1 m from (0, 0).
FloorGrid grid_of(const std::vector<std::string>& rows) {
  image::Image<FloorCell> cells(static_cast<int>(rows.front().size()),
                                static_cast<int>(rows.size()));
  for (int row = 0; row < cells.height(); ++row) {
    for (int column = 0; column < cells.width(); ++column) {
      const char sign = rows[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)];
      cells.at(column, row) = sign == '.'   ? FloorCell::kFree
                              : sign == '#' ? FloorCell::kOccupied
                                            : FloorCell::kUnknown;
    }
  }
  return {Vector2d::Zero(), kCell_m, std::move(cells)};
}

// Straight on from one point to another, a place every 0.2 m.
void walk_to(WalkedPath& path, const Vector2d& to, const std::string& room) {
  const Vector2d from = path.empty() ? to : path.back().point_plan;
  const int steps = std::max(1, static_cast<int>(std::ceil((to - from).norm() / 0.2)));
  for (int i = 1; i <= steps; ++i) path.push_back({from + (to - from) * i / steps, room});
}

// Two rooms of 3 m by 2 m beside each other, the wall at x = 3 to 3.2 m with a door of 0.8 m about
// y = 0.6 m. A table of 0.6 m stands in the left room, so that 0.5 m are left beside it.
std::vector<std::string> plan_of_two_rooms() {
  std::vector<std::string> rows(20, fmt::format("{:.<30}##{:.<30}", "", ""));
  for (std::size_t row = 2; row < 10; ++row) rows[row].replace(30, 2, "..");
  for (std::size_t row = 9; row < 15; ++row) rows[row].replace(10, 6, "######");
  return rows;
}

// From the left room into the right one; the helper named the right one `late_m` after the door.
WalkedPath walk_through(double late_m) {
  WalkedPath path;
  walk_to(path, {0.5, 0.6}, "bedroom");
  walk_to(path, {3.1 + late_m, 0.6}, "bedroom");
  walk_to(path, {5.5, 0.6}, "kitchen");
  walk_to(path, {5.5, 1.5}, "kitchen");
  return path;
}

TEST(RoomLayoutTest, FloorIsWhatTheMapShowsFreeOrSomebodyWalkedOn) {
  auto rows = plan_of_two_rooms();
  for (std::string& row : rows) row.replace(40, 5, "     ");  // nobody looked down there
  const std::vector<WalkedPath> walks{walk_through(0)};
  const auto layout = RoomLayout::make(grid_of(rows), walks);
  ASSERT_OK(layout);
  EXPECT_TRUE(layout->is_floor(5, 5));
  EXPECT_TRUE(layout->is_floor(42, 6)) << "the walk led there";
  EXPECT_FALSE(layout->is_floor(42, 18));
  EXPECT_FALSE(layout->is_floor(12, 12)) << "a table";
  EXPECT_FALSE(layout->is_floor(-1, 5));
}

TEST(RoomLayoutTest, RoomsMeetAtTheDoorAlthoughTheyWereNamedEarlyOrLate) {
  for (const double late_m : {-0.6, 0.0, 0.6}) {
    const std::vector<WalkedPath> walks{walk_through(late_m)};
    const auto layout = RoomLayout::make(grid_of(plan_of_two_rooms()), walks);
    ASSERT_OK(layout);
    EXPECT_THAT(layout->room_at({2.7, 1.9}), Optional(std::string("bedroom"))) << late_m;
    EXPECT_THAT(layout->room_at({2.85, 0.6}), Optional(std::string("bedroom"))) << late_m;
    EXPECT_THAT(layout->room_at({3.35, 0.6}), Optional(std::string("kitchen"))) << late_m;
    EXPECT_THAT(layout->room_at({3.4, 1.9}), Optional(std::string("kitchen"))) << late_m;
    ASSERT_EQ(layout->doorways().size(), 1U) << late_m;
    const Doorway& door = layout->doorways().front();
    EXPECT_THAT(door.rooms, ElementsAre("bedroom", "kitchen"));
    EXPECT_NEAR(door.middle_plan.x(), 3.1, 0.15);
    EXPECT_NEAR(door.middle_plan.y(), 0.6, 0.11);
    EXPECT_NEAR(door.width_m, 0.8, 0.15);
    EXPECT_TRUE(door.is_walked);
    EXPECT_TRUE(door.is_door());
    EXPECT_THAT(layout->neighbors("kitchen"), ElementsAre("bedroom"));
  }
}

TEST(RoomLayoutTest, TheWalkTheOtherWayRoundGivesTheSameRooms) {
  std::vector<WalkedPath> walks{walk_through(0.3)};
  const auto there = RoomLayout::make(grid_of(plan_of_two_rooms()), walks);
  std::ranges::reverse(walks.front());
  const auto back = RoomLayout::make(grid_of(plan_of_two_rooms()), walks);
  ASSERT_OK(there);
  ASSERT_OK(back);
  int differ = 0;
  for (int row = 0; row < 20; ++row) {
    for (int column = 0; column < 62; ++column) {
      differ += there->room_of_cell(column, row) != back->room_of_cell(column, row) ? 1 : 0;
    }
  }
  EXPECT_LE(differ, 8) << "cells in the door, where both are equally near";
}

TEST(RoomLayoutTest, FloorIsMeasured) {
  const std::vector<WalkedPath> walks{walk_through(0)};
  const auto layout = RoomLayout::make(grid_of(plan_of_two_rooms()), walks);
  ASSERT_OK(layout);
  ASSERT_EQ(layout->rooms().size(), 2U);
  EXPECT_EQ(layout->rooms()[0].name, "bedroom");
  EXPECT_NEAR(layout->rooms()[0].floor_m2, 6 - 0.36, 0.17);
  EXPECT_NEAR(layout->rooms()[1].floor_m2, 6, 0.17);
  // The kitchen is empty: its middle is as far from the walls as can be.
  EXPECT_NEAR(layout->rooms()[1].middle_plan.y(), 1, 0.11);
}

TEST(RoomLayoutTest, FurnitureBelongsToTheRoomWhoseFloorIsNearest) {
  // A wardrobe of 0.5 m stands in the kitchen at the wall to the bedroom.
  std::vector<std::string> rows = plan_of_two_rooms();
  for (std::size_t row = 12; row < 20; ++row) rows[row].replace(32, 5, "#####");
  const std::vector<WalkedPath> walks{walk_through(0)};
  const auto layout = RoomLayout::make(grid_of(rows), walks);
  ASSERT_OK(layout);
  EXPECT_THAT(layout->room_at({1.35, 1.2}), Optional(std::string("bedroom"))) << "the table";
  EXPECT_THAT(layout->room_at({3.55, 1.6}), Optional(std::string("kitchen"))) << "the wardrobe";
  EXPECT_EQ(layout->room_at({-0.5, 1}), std::nullopt) << "outside";
}

TEST(RoomLayoutTest, WhatIsFarFromAllFloorBelongsToNoRoom) {
  std::vector<std::string> rows = plan_of_two_rooms();
  for (std::string& row : rows) row.append(20, ' ');
  RoomLayoutOptions options;
  options.furniture_depth_m = 0.5;
  const std::vector<WalkedPath> walks{walk_through(0)};
  const auto layout = RoomLayout::make(grid_of(rows), walks, options);
  ASSERT_OK(layout);
  EXPECT_THAT(layout->room_at({6.6, 1}), Optional(std::string("kitchen")));
  EXPECT_EQ(layout->room_at({6.8, 1}), std::nullopt);
}

TEST(RoomLayoutTest, AnOpeningThatNobodyWalkedThroughIsThereAllTheSame) {
  std::vector<std::string> rows = plan_of_two_rooms();
  for (std::size_t row = 13; row < 19; ++row) rows[row].replace(30, 2, "..");
  const std::string with_wall = fmt::format("{:.<30}##{:.<30}", "", "");
  rows.insert(rows.begin() + 11, 24, with_wall);
  const std::vector<WalkedPath> walks{walk_through(0)};
  const auto layout = RoomLayout::make(grid_of(rows), walks);
  ASSERT_OK(layout);
  ASSERT_EQ(layout->doorways().size(), 2U);
  EXPECT_TRUE(layout->doorways()[0].is_walked) << "the wider one, with the walk";
  EXPECT_FALSE(layout->doorways()[1].is_walked);
  EXPECT_NEAR(layout->doorways()[1].middle_plan.y(), 4, 0.11);
}

TEST(RoomLayoutTest, AGapThatNobodyFitsThroughIsNoDoorway) {
  std::vector<std::string> rows = plan_of_two_rooms();
  for (std::size_t row = 16; row < 18; ++row) rows[row].replace(30, 2, "..");
  const std::vector<WalkedPath> walks{walk_through(0)};
  const auto layout = RoomLayout::make(grid_of(rows), walks);
  ASSERT_OK(layout);
  EXPECT_EQ(layout->doorways().size(), 1U);
}

// The two rooms without the floor between them.
std::vector<std::string> unseen_door() {
  std::vector<std::string> rows = plan_of_two_rooms();
  for (std::string& row : rows) row.replace(30, 2, "  ");
  return rows;
}

TEST(RoomLayoutTest, WhereSomebodyWalkedIsFloorAlthoughItWasNotSeen) {
  const std::vector<WalkedPath> walks{walk_through(0)};
  const auto layout = RoomLayout::make(grid_of(unseen_door()), walks);
  ASSERT_OK(layout);
  ASSERT_EQ(layout->doorways().size(), 1U);
  EXPECT_NEAR(layout->doorways().front().width_m, 0.5, 0.11) << "as wide as who walked";
  EXPECT_NEAR(layout->doorways().front().middle_plan.y(), 0.6, 0.11);
  EXPECT_TRUE(layout->doorways().front().is_walked);
  EXPECT_FALSE(layout->doorways().front().is_door()) << "no frame was seen beside it";
}

TEST(RoomLayoutTest, NobodyWalksThroughThings) {
  std::vector<std::string> rows = unseen_door();
  for (std::string& row : rows) row.replace(30, 2, "##");
  const std::vector<WalkedPath> walks{walk_through(0)};
  const auto layout = RoomLayout::make(grid_of(rows), walks);
  ASSERT_OK(layout);
  ASSERT_EQ(layout->doorways().size(), 1U);
  EXPECT_EQ(layout->doorways().front().width_m, 0) << "the camera was held over something";
  EXPECT_FALSE(layout->doorways().front().is_door());
}

TEST(RoomLayoutTest, ADoorThatWasPassedWhileLostIsKnownFromTheNames) {
  WalkedPath path = walk_through(0);
  std::erase_if(
      path, [](const WalkedPlace& place) { return std::abs(place.point_plan.x() - 3.1) < 0.8; });
  const std::vector<WalkedPath> walks{path};
  const auto layout = RoomLayout::make(grid_of(unseen_door()), walks);
  ASSERT_OK(layout);
  ASSERT_EQ(layout->doorways().size(), 1U);
  EXPECT_EQ(layout->doorways().front().width_m, 0);
  EXPECT_TRUE(layout->doorways().front().is_walked);
  EXPECT_NEAR(layout->doorways().front().middle_plan.x(), 3.1, 0.2);
}

TEST(RoomLayoutTest, NoDoorIsMadeUpWhereTheWalkIsNotKnown) {
  WalkedPath lost = walk_through(0);
  std::erase_if(
      lost, [](const WalkedPlace& place) { return std::abs(place.point_plan.x() - 3.1) < 1.6; });
  WalkedPath unnamed = walk_through(0);
  for (WalkedPlace& place : unnamed) {
    if (std::abs(place.point_plan.x() - 3.1) < 0.8) place.room.clear();
  }
  std::vector<std::string> rows = unseen_door();
  for (std::string& row : rows) row.replace(30, 2, "##");
  for (const WalkedPath& path : {lost, unnamed}) {
    const std::vector<WalkedPath> walks{path};
    const auto layout = RoomLayout::make(grid_of(rows), walks);
    ASSERT_OK(layout);
    EXPECT_TRUE(layout->doorways().empty());
    EXPECT_EQ(layout->rooms().size(), 2U);
  }
}

// The kitchen of the two rooms was walked in without a name, from `late_m` after the door on.
WalkedPath walk_into_nameless(double late_m) {
  WalkedPath path = walk_through(late_m);
  for (WalkedPlace& place : path) {
    if (place.room == "kitchen") place.room.clear();
  }
  return path;
}

TEST(RoomLayoutTest, ARoomThatNobodyNamedIsNotThatBesideIt) {
  for (const double late_m : {-0.6, 0.0, 0.6}) {
    const std::vector<WalkedPath> walks{walk_into_nameless(late_m)};
    const auto layout = RoomLayout::make(grid_of(plan_of_two_rooms()), walks);
    ASSERT_OK(layout);
    ASSERT_EQ(layout->rooms().size(), 1U);
    EXPECT_NEAR(layout->rooms()[0].floor_m2, 6 - 0.36, 0.35) << late_m;
    EXPECT_THAT(layout->room_at({2.7, 1.9}), Optional(std::string("bedroom"))) << late_m;
    EXPECT_EQ(layout->room_at({3.6, 0.6}), std::nullopt) << late_m;
    EXPECT_EQ(layout->room_at({5.5, 1.5}), std::nullopt) << late_m;
    EXPECT_THAT(layout->doorways(), IsEmpty()) << "it leads to no room that has a name";
    EXPECT_NEAR(layout->nameless_share_around({5, 1}, 0.2), 1, 1e-9);
    EXPECT_NEAR(layout->nameless_share_around({1, 1}, 0.2), 0, 1e-9);
    EXPECT_EQ(layout->nameless_share_around({50, 1}, 0.2), 0) << "outside";
  }
}

TEST(RoomLayoutTest, AShortStretchWithoutANameTearsNoHole) {
  WalkedPath path = walk_through(0);
  for (WalkedPlace& place : path) {
    if (place.room == "kitchen" && place.point_plan.x() < 4.6) place.room.clear();
  }
  const std::vector<WalkedPath> walks{path};
  const auto layout = RoomLayout::make(grid_of(plan_of_two_rooms()), walks);
  ASSERT_OK(layout);
  ASSERT_EQ(layout->rooms().size(), 2U);
  EXPECT_NEAR(layout->rooms()[1].floor_m2, 6, 0.35);
}

TEST(RoomLayoutTest, WhatWasNamedOnAnotherWalkIsNamed) {
  WalkedPath unnamed = walk_through(0);
  for (WalkedPlace& place : unnamed) place.room.clear();
  const std::vector<WalkedPath> walks{walk_through(0), unnamed};
  const auto layout = RoomLayout::make(grid_of(plan_of_two_rooms()), walks);
  ASSERT_OK(layout);
  ASSERT_EQ(layout->rooms().size(), 2U);
  EXPECT_NEAR(layout->rooms()[0].floor_m2, 6 - 0.36, 0.17);
  EXPECT_NEAR(layout->rooms()[1].floor_m2, 6, 0.17);
}

TEST(RoomLayoutTest, ShortVisitsToAHallCount) {
  // Through the door lies a hall of 1 m, all of it near a crossing.
  WalkedPath path;
  walk_to(path, {0.5, 0.6}, "bedroom");
  walk_to(path, {3.1, 0.6}, "bedroom");
  walk_to(path, {4.1, 0.6}, "hall");
  walk_to(path, {5.5, 0.6}, "kitchen");
  std::vector<std::string> rows = plan_of_two_rooms();
  for (std::size_t row = 10; row < 20; ++row) rows[row].replace(42, 1, "#");
  for (std::size_t row = 0; row < 2; ++row) rows[row].replace(42, 1, "#");
  const std::vector<WalkedPath> walks{path};
  const auto layout = RoomLayout::make(grid_of(rows), walks);
  ASSERT_OK(layout);
  EXPECT_THAT(layout->room_at({3.6, 1.8}), Optional(std::string("hall")));
  EXPECT_THAT(layout->neighbors("hall"), ElementsAre("bedroom", "kitchen"));
}

// Floor of 8 m by 4 m without a wall.
std::vector<std::string> plan_of_an_open_floor() {
  return std::vector<std::string>(40, fmt::format("{:.<80}", ""));
}

TEST(RoomLayoutTest, RoomsThatAreOpenToEachOtherMeetHalfwayAndTheWiderTakesNotAll) {
  // One is walked through its midst, the other along its edge, where less is free around.
  WalkedPath path;
  walk_to(path, {1, 2}, "dining room");
  walk_to(path, {4, 2}, "dining room");
  walk_to(path, {6, 0.4}, "lounge");
  walk_to(path, {7.5, 0.4}, "lounge");
  const auto layout =
      RoomLayout::make(grid_of(plan_of_an_open_floor()), std::vector<WalkedPath>{path});
  ASSERT_OK(layout);
  EXPECT_THAT(layout->room_at({7, 2.5}), Optional(std::string("lounge")));
  EXPECT_THAT(layout->room_at({2, 3.5}), Optional(std::string("dining room")));
}

TEST(RoomLayoutTest, TheMiddleOfARoomIsFarFromItsOpenBorders) {
  const std::vector<std::string> open(20, std::string(60, '.'));
  WalkedPath path;
  walk_to(path, {0.5, 1}, "bedroom");
  walk_to(path, {2.9, 1}, "bedroom");
  walk_to(path, {5.5, 1}, "kitchen");
  const auto layout = RoomLayout::make(grid_of(open), std::vector<WalkedPath>{path});
  ASSERT_OK(layout);
  ASSERT_EQ(layout->rooms().size(), 2U);
  ASSERT_EQ(layout->doorways().size(), 1U);
  const double border_m = layout->doorways().front().middle_plan.x();
  EXPECT_EQ(layout->rooms()[1].name, "kitchen");
  EXPECT_GT(layout->rooms()[1].middle_plan.x(), border_m + 0.8);
  EXPECT_LT(layout->rooms()[0].middle_plan.x(), border_m - 0.8);
}

TEST(RoomLayoutTest, TheBorderOfRoomsThatAreOpenToEachOtherIsNoDoor) {
  WalkedPath path;
  walk_to(path, {1, 2}, "dining room");
  walk_to(path, {4, 2}, "dining room");
  walk_to(path, {7, 2}, "lounge");
  const auto layout =
      RoomLayout::make(grid_of(plan_of_an_open_floor()), std::vector<WalkedPath>{path});
  ASSERT_OK(layout);
  ASSERT_EQ(layout->doorways().size(), 1U);
  EXPECT_FALSE(layout->doorways()[0].is_door());
  EXPECT_GT(layout->doorways()[0].width_m, 3);
}

// Dining room left of x = 4 m, lounge right of it, and what stands between them.
RoomLayout open_rooms_with(const std::vector<std::string>& rows) {
  WalkedPath path;
  walk_to(path, {1, 2}, "dining room");
  walk_to(path, {4.2, 2}, "dining room");
  walk_to(path, {7, 2}, "lounge");
  return RoomLayout::make(grid_of(rows), std::vector<WalkedPath>{path}).value();
}

TEST(RoomLayoutTest, TwoChairsOnAnOpenBorderMakeNoDoor) {
  std::vector<std::string> rows = plan_of_an_open_floor();
  for (const std::size_t from : {11U, 25U}) {
    for (std::size_t row = from; row < from + 4; ++row) rows[row].replace(40, 4, "####");
  }
  const RoomLayout layout = open_rooms_with(rows);
  ASSERT_FALSE(layout.doorways().empty());
  for (const Doorway& doorway : layout.doorways()) EXPECT_FALSE(doorway.is_door());
}

TEST(RoomLayoutTest, WallsFrameADoorAlsoWhereDoorsAreAllAroundThem) {
  // A wall of 2.8 m between two doors of the same rooms.
  std::vector<std::string> rows = plan_of_an_open_floor();
  for (std::size_t row = 0; row < 40; ++row) {
    const bool is_door = (row >= 2 && row < 6) || (row >= 34 && row < 38);
    if (!is_door) rows[row].replace(40, 2, "##");
  }
  WalkedPath path;
  walk_to(path, {1, 0.4}, "dining room");
  walk_to(path, {4.1, 0.4}, "dining room");
  walk_to(path, {7, 0.4}, "lounge");
  const auto two = RoomLayout::make(grid_of(rows), std::vector<WalkedPath>{path});
  ASSERT_OK(two);
  ASSERT_EQ(two->doorways().size(), 2U);
  for (const Doorway& doorway : two->doorways()) EXPECT_TRUE(doorway.is_door());

  // Shorter walls, at which three rooms meet.
  rows = std::vector<std::string>(40, fmt::format("{:.<30}##{:.<30}", "", ""));
  for (std::size_t row = 2; row < 12; ++row) rows[row].replace(30, 2, "..");
  for (std::size_t row = 28; row < 38; ++row) rows[row].replace(30, 2, "..");
  for (std::size_t row = 19; row < 21; ++row) {
    rows[row].replace(32, 30, "############.........#########");
  }
  path.clear();
  walk_to(path, {1, 0.7}, "hall");
  walk_to(path, {3.1, 0.7}, "hall");
  walk_to(path, {4.8, 0.7}, "kitchen");
  walk_to(path, {4.8, 2}, "kitchen");
  walk_to(path, {4.8, 3.3}, "lounge");
  walk_to(path, {3.1, 3.3}, "lounge");
  walk_to(path, {1, 3.3}, "hall");
  const auto three = RoomLayout::make(grid_of(rows), std::vector<WalkedPath>{path});
  ASSERT_OK(three);
  ASSERT_EQ(three->doorways().size(), 3U);
  for (const Doorway& doorway : three->doorways()) {
    EXPECT_TRUE(doorway.is_door()) << doorway.rooms[0] << " - " << doorway.rooms[1];
  }
}

TEST(RoomLayoutTest, AnOpeningIsWhereAWalkLedThroughAndNoFrameWasSeen) {
  const std::vector<WalkedPath> walks{walk_through(0)};
  const auto unseen = RoomLayout::make(grid_of(unseen_door()), walks);
  ASSERT_OK(unseen);
  EXPECT_TRUE(unseen->doorways().front().is_opening());
  const auto seen = RoomLayout::make(grid_of(plan_of_two_rooms()), walks);
  ASSERT_OK(seen);
  EXPECT_FALSE(seen->doorways().front().is_opening()) << "a door";
  EXPECT_NEAR(std::abs(std::sin(seen->doorways().front().direction_rad)), 1, 0.03) << "along y";
  const RoomLayout open = open_rooms_with(plan_of_an_open_floor());
  EXPECT_FALSE(open.doorways().front().is_opening()) << "rooms that are open to each other";
}

TEST(RoomLayoutTest, ADoorThatSomebodyAddsIsTheDoorAtAPlaceThatShowsNone) {
  const std::vector<WalkedPath> walks{walk_through(0)};
  const std::vector<LayoutEdit> edits{
      AddedDoor{.rooms = {"kitchen", "bedroom"}, .middle_plan = {3.1, 0.5}}};
  const auto layout = RoomLayout::make(grid_of(unseen_door()), walks, {}, edits);
  ASSERT_OK(layout);
  ASSERT_EQ(layout->doorways().size(), 1U) << "one place has one doorway";
  EXPECT_TRUE(layout->doorways()[0].is_door());
  EXPECT_NEAR(layout->doorways()[0].middle_plan.y(), 0.5, 1e-9);
}

TEST(RoomLayoutTest, RoomsThatAreOpenAroundATableHaveOneBorder) {
  std::vector<std::string> rows = plan_of_an_open_floor();
  for (std::size_t row = 14; row < 22; ++row) rows[row].replace(33, 20, std::string(20, '#'));
  WalkedPath path;
  walk_to(path, {1, 1}, "dining room");
  walk_to(path, {4.2, 1}, "dining room");
  walk_to(path, {7, 1}, "lounge");
  walk_to(path, {7, 3}, "lounge");
  walk_to(path, {4.2, 3}, "lounge");
  walk_to(path, {1, 3}, "dining room");
  const auto layout = RoomLayout::make(grid_of(rows), std::vector<WalkedPath>{path});
  ASSERT_OK(layout);
  ASSERT_EQ(layout->doorways().size(), 1U);
  EXPECT_FALSE(layout->doorways()[0].is_door());
  EXPECT_TRUE(layout->doorways()[0].is_walked);
}

// A bedroom has a door to a kitchen and, 2.4 m from it, one to a lounge. On a later walk the
// kitchen was called the lounge for the first step.
TEST(RoomLayoutTest, OnePlaceHasOneDoorwayAlthoughANameCameLate) {
  std::vector<std::string> rows(40, fmt::format("{:.<30}##{:.<30}", "", ""));
  for (std::size_t row = 2; row < 10; ++row) rows[row].replace(30, 2, "..");
  for (std::size_t row = 26; row < 34; ++row) rows[row].replace(30, 2, "..");
  rows[18].replace(30, 32, std::string(32, '#'));
  const auto through = [](double y, const std::string& first, const std::string& then) {
    WalkedPath path;
    walk_to(path, {0.5, y}, "bedroom");
    walk_to(path, {3.1, y}, "bedroom");
    walk_to(path, {3.7, y}, first);
    walk_to(path, {5.5, y}, then);
    return path;
  };
  const std::vector<WalkedPath> walks{through(0.6, "kitchen", "kitchen"),
                                      through(3, "lounge", "lounge"),
                                      through(0.6, "lounge", "kitchen")};
  const auto layout = RoomLayout::make(grid_of(rows), walks);
  ASSERT_OK(layout);
  std::vector<std::string> ways;
  for (const Doorway& doorway : layout->doorways()) {
    if (doorway.is_door()) ways.push_back(doorway.rooms[0] + " - " + doorway.rooms[1]);
    const bool is_at_door = (doorway.middle_plan - Vector2d(3.1, 0.6)).norm() < 0.5;
    EXPECT_TRUE(!is_at_door || doorway.is_door()) << doorway.rooms[0] << doorway.rooms[1];
  }
  EXPECT_THAT(ways, ElementsAre("bedroom - kitchen", "bedroom - lounge"));
}

TEST(RoomLayoutTest, ARoomNeverOnFreeFloorHasNoFloorAndIsNotForgotten) {
  WalkedPath path = walk_through(0);
  walk_to(path, {9, 1.5}, "porch");
  const std::vector<WalkedPath> walks{path};
  const auto layout = RoomLayout::make(grid_of(plan_of_two_rooms()), walks);
  ASSERT_OK(layout);
  ASSERT_EQ(layout->rooms().size(), 3U);
  EXPECT_EQ(layout->rooms()[2].name, "porch");
  EXPECT_THAT(layout->neighbors("porch"), ElementsAre("kitchen"));
}

// As a home that was named badly has it.
void expect_no_floor(const Vector2d& place, const std::string& room) {
  const std::vector<WalkedPath> walks{WalkedPath{{place, room}}};
  const auto layout = RoomLayout::make(grid_of(plan_of_two_rooms()), walks);
  ASSERT_OK(layout);
  EXPECT_FALSE(layout->has_floor());
  EXPECT_EQ(layout->room_at({1, 0.5}), std::nullopt);
  EXPECT_THAT(layout->doorways(), IsEmpty());
}

TEST(RoomLayoutTest, PlacesWithoutNameOrNumberGiveNoFloor) {
  expect_no_floor({1, 0.5}, "");
  expect_no_floor({std::numeric_limits<double>::quiet_NaN(), 0.5}, "hall");
  expect_no_floor({1e300, 0.5}, "hall");
}

TEST(RoomLayoutTest, OptionsAreLengths) {
  RoomLayoutOptions options;
  options.furniture_depth_m = -1;
  const std::vector<WalkedPath> walks{walk_through(0)};
  const auto layout = RoomLayout::make(grid_of(plan_of_two_rooms()), walks, options);
  ASSERT_FALSE(layout);
  EXPECT_THAT(layout.error().message, HasSubstr("furniture_depth_m must be a length"));
}

// ---- room_probabilities ----

// Bath and hall, 3 m by 2 m each, open to each other at x = 3 m.
RoomLayout two_open_rooms() {
  WalkedPath walk;
  walk_to(walk, {0.5, 1}, "bath");
  walk_to(walk, {2.9, 1}, "bath");
  walk_to(walk, {5.5, 1}, "hall");
  return RoomLayout::make(grid_of(std::vector<std::string>(20, std::string(60, '.'))),
                          std::span(&walk, 1))
      .value();
}

TEST(SharesAround, DeepInARoomAllIsThatRoom) {
  const RoomLayout layout = two_open_rooms();
  const auto shares = layout.room_probabilities({1.2, 1}, 0.2);
  ASSERT_EQ(shares.size(), 2U);
  EXPECT_NEAR(shares[0], 1, 1e-9) << "three standard deviations are 0.6 m";
  EXPECT_EQ(shares[1], 0);
}

TEST(SharesAround, AtABoundaryBothRoomsHaveHalf) {
  const RoomLayout layout = two_open_rooms();
  const auto shares = layout.room_probabilities({3, 1}, 0.2);
  EXPECT_NEAR(shares[0], 0.5, 0.15) << "the boundary is known to a cell, half a deviation";
  EXPECT_NEAR(shares[0] + shares[1], 1, 1e-9);
  // A step on into the hall there is little left of the bath.
  EXPECT_LT(layout.room_probabilities({3.5, 1}, 0.2)[0], 0.05);
}

TEST(SharesAround, OutsideAllFloorsNoRoomHasAny) {
  const RoomLayout layout = two_open_rooms();
  for (const Vector2d& point : {Vector2d(-5, 1), Vector2d(3, 40), Vector2d(1e12, 1)}) {
    EXPECT_THAT(layout.room_probabilities(point, 0.2), ElementsAre(0, 0));
  }
  // At the edge of the floor half is outside, and belongs to nobody.
  const auto edge = layout.room_probabilities({1.2, 0}, 0.2);
  EXPECT_NEAR(edge[0], 0.5, 0.11);
  EXPECT_EQ(edge[1], 0);
}

TEST(SharesAround, SpreadTheMoreTheLessThePointIsKnown) {
  const RoomLayout layout = two_open_rooms();
  double own = 1.01;
  double others = -0.01;
  for (const double sigma_m : {0.1, 0.4, 0.8, 1.6, 3.2}) {
    const auto shares = layout.room_probabilities({2, 1}, sigma_m);
    EXPECT_LT(shares[0], own + 1e-9) << sigma_m;
    own = shares[0];
    const double not_own = 1 - shares[0];
    EXPECT_GE(not_own, others) << sigma_m;
    others = not_own;
  }
  EXPECT_LT(own, 0.3);
  EXPECT_GT(layout.room_probabilities({2, 1}, 0.8)[1], 0.05) << "some of it is in the next room";
}

TEST(SharesAround, AreHowOftenANormalDistributionLiesInEachRoom) {
  const RoomLayout layout = two_open_rooms();
  RandomStream random(3);
  for (const auto& [point, sigma_m] :
       {std::pair(Vector2d(2.7, 0.9), 0.3), {Vector2d(3.4, 1.6), 0.5}, {Vector2d(0.3, 0.2), 0.7}}) {
    constexpr int kDraws = 20000;
    std::vector<double> counted(2, 0);
    for (int i = 0; i < kDraws; ++i) {
      const Vector2d drawn = point + sigma_m * Vector2d(random.normal(), random.normal());
      const auto room = layout.room_at(drawn);
      if (room) counted[*room == "bath" ? 0 : 1] += 1.0 / kDraws;
    }
    const auto shares = layout.room_probabilities(point, sigma_m);
    EXPECT_NEAR(shares[0], counted[0], 0.08) << point.transpose();
    EXPECT_NEAR(shares[1], counted[1], 0.08) << point.transpose();
  }
}

}  // namespace
}  // namespace roomwise::rooms
