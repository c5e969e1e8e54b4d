#include "roomwise/guide/way/route.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/guide/answers/route_prompts.h"
#include "roomwise/guide/testing/drawn_floor.h"

namespace roomwise::guide {
namespace {

using Eigen::Vector2d;
using fusion::FloorCell;
using fusion::FloorGrid;
using ::testing::ElementsAre;
using testing::Floor;
using ::testing::HasSubstr;

// A straight corridor of 6 m by 1.2 m.
FloorGrid corridor() {
  return Floor(60, 12).grid();
}
// An L: 4 m along x, then 4 m along y, 1.4 m wide.
Floor l_shape() {
  return Floor(40, 40).fill({1, 15}, {26, 39}, FloorCell::kOccupied);
}

class RoutePromptsTest : public ::testing::Test {
 protected:
  [[nodiscard]] std::vector<std::string> words(const Expected<Route>& route, double heading_rad,
                                               const std::vector<rooms::Doorway>& doors = {}) {
    std::vector<std::string> texts;
    const Pose pose{route->front(), heading_rad, 0.05};
    for (const Prompt& prompt :
         route_prompts(*route, pose, {Noun::Kind::kThing, "microwave"}, doors, wording_, 0)) {
      texts.push_back(prompt.text);
    }
    return texts;
  }

  const MessageCatalogue catalogue_ = MessageCatalogue::built_in();
  const Wording wording_{&catalogue_, {"en", DistanceUnit::kSteps, 0.5}};
};

TEST(RouteTest, AStraightCorridorIsOneLine) {
  const auto route = find_route(corridor(), {0.65, 0.6}, {5.25, 0.6});
  ASSERT_OK(route);
  ASSERT_EQ(route->size(), 2u);
  EXPECT_NEAR(length_m(*route), 4.6, 0.1);
}

TEST(RouteTest, AroundACornerThereIsAPersonsRoom) {
  const FloorGrid grid = l_shape().grid();
  const auto route = find_route(grid, {0.65, 0.75}, {3.3, 3.4});
  ASSERT_OK(route);
  EXPECT_GE(route->size(), 3u);
  EXPECT_LE(route->size(), 5u);
  // Around the corner at (2.6, 1.5).
  EXPECT_GT(length_m(*route), 3.9);
  EXPECT_LT(length_m(*route), 5.4);
}

TEST(RouteTest, BlockedWaysAndNarrowOnesAreNone) {
  const Floor blocked = l_shape().fill({26, 20}, {39, 22}, FloorCell::kOccupied);
  EXPECT_ERROR(find_route(blocked.grid(), {0.65, 0.75}, {3.3, 3.4}), "leads to the goal");
  // What was never seen is not free either.
  const Floor unseen = l_shape().fill({26, 20}, {39, 22}, FloorCell::kUnknown);
  EXPECT_ERROR(find_route(unseen.grid(), {0.65, 0.75}, {3.3, 3.4}), "leads to the goal");
  // A gap of 0.5 m, then one of 0.8 m.
  Floor narrow = l_shape().fill({26, 20}, {39, 22}, FloorCell::kOccupied);
  narrow.fill({30, 20}, {35, 22}, FloorCell::kFree);
  EXPECT_ERROR(find_route(narrow.grid(), {0.65, 0.75}, {3.3, 3.4}), "wide enough");
  narrow.fill({28, 20}, {36, 22}, FloorCell::kFree);
  EXPECT_OK(find_route(narrow.grid(), {0.65, 0.75}, {3.3, 3.4}));
}

TEST(RouteTest, BeginsAndEndsOnFreeFloor) {
  // At the wall, and to a table that stands against the wall.
  const Floor floor = Floor(60, 30).fill({40, 20}, {52, 29}, FloorCell::kOccupied);
  const auto route = find_route(floor.grid(), {0.15, 1.5}, {4.6, 2.5});
  ASSERT_OK(route);
  EXPECT_GE(route->front().x(), 0.39);
  EXPECT_NEAR((route->back() - Vector2d(4.6, 2.5)).norm(), 0.9, 0.15);
  EXPECT_ERROR(find_route(floor.grid(), {-3, 1}, {4.6, 2.5}), "where the way begins");
  EXPECT_ERROR(find_route(floor.grid(), {0.65, 1.5}, {9, 9}), "near the goal");
  EXPECT_ERROR(find_route(floor.grid(), {0.65, 1.5}, {1, 1}, {.comfort_m = 0.1}), "comfort_m");
}

// A thing at a wall is nearer to the floor of the room behind it.
TEST(RouteTest, EndsInTheRoomOfTheThing) {
  Floor floor(60, 30);
  floor.fill({30, 1}, {31, 22}, FloorCell::kOccupied);  // a wall with a door at its end
  floor.fill({22, 5}, {30, 12}, FloorCell::kOccupied);  // the thing, left of it
  rooms::WalkedPath walk;
  for (int i = 0; i <= 20; ++i) {
    walk.push_back({Vector2d(0.5 + 0.25 * i, 2.5), i < 10 ? "bedroom" : "kitchen"});
  }
  const std::vector<rooms::WalkedPath> walks{walk};
  const FloorGrid grid = floor.grid();
  const auto layout = rooms::RoomLayout::make(grid, walks);
  ASSERT_OK(layout);
  const Vector2d thing(2.9, 0.8);
  const auto behind = find_route(grid, {5, 0.8}, thing);
  ASSERT_OK(behind);
  EXPECT_GT(behind->back().x(), 3.1);
  const auto before = find_route(grid, {5, 0.8}, thing, {}, &*layout, "bedroom");
  ASSERT_OK(before);
  EXPECT_LT(before->back().x(), 3.0);
  EXPECT_GT(length_m(*before), length_m(*behind) + 2);
}

// Whatever stands on the floor: the way stays clear of it and is no longer than one along the
// cells.
TEST(RouteTest, StaysClearOfEverything) {
  int found = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    RandomStream random(seed);
    Floor floor(60, 50);
    for (int i = 0; i < 12; ++i) {
      const Eigen::Vector2i from(static_cast<int>(random.index(55)),
                                 static_cast<int>(random.index(45)));
      floor.fill(from, from + Eigen::Vector2i(5, 5), FloorCell::kOccupied);
    }
    const FloorGrid grid = floor.grid();
    const auto route = find_route(grid, {0.5, 0.5}, {5.5, 4.5});
    if (!route) continue;
    ++found;
    EXPECT_GE(length_m(*route), 0.9 * ((*route).back() - (*route).front()).norm());
    for (std::size_t i = 1; i < route->size(); ++i) {
      for (int step = 0; step <= 100; ++step) {
        const Vector2d place = (*route)[i - 1] + ((*route)[i] - (*route)[i - 1]) * step / 100.0;
        // Between the checked places of a line, half a cell may be missing.
        EXPECT_TRUE(grid.fits(place, 0.3 - Floor::kCell_m / 2)) << seed;
      }
    }
  }
  EXPECT_GT(found, 15);
}

TEST_F(RoutePromptsTest, AStraightWayIsOneSentence) {
  const auto route = find_route(corridor(), {0.65, 0.6}, {5.25, 0.6});
  EXPECT_THAT(words(route, 0), ElementsAre("Straight on, then 9 steps to the microwave."));
  EXPECT_THAT(words(route, std::numbers::pi),
              ElementsAre("Turn around, then 9 steps to the microwave."));
  EXPECT_THAT(words(route, std::numbers::pi / 2),
              ElementsAre("Turn right, then 9 steps to the microwave."));
  EXPECT_THAT(words(route, -0.7),
              ElementsAre("Turn slightly left, then 9 steps to the microwave."));
}

TEST_F(RoutePromptsTest, DoorsAndCornersEndALeg) {
  const Route route{Vector2d(0, 0), Vector2d(4, 0), Vector2d(4, 2)};
  rooms::Doorway door;
  door.rooms = {"corridor", "kitchen"};
  door.middle_plan = Vector2d(2, 0.1);
  door.width_m = 0.8;
  door.direction_rad = std::numbers::pi / 2;
  door.is_framed = true;
  EXPECT_THAT(words(route, 0, {door}),
              ElementsAre("Straight on, then 4 steps to the door.", "Straight on, then 4 steps.",
                          "Turn left, then 4 steps to the microwave."));
  door.is_framed = false;  // the rooms are open to each other there
  EXPECT_EQ(words(route, 0, {door}), words(route, 0));
  EXPECT_THAT(words(route, 0), ElementsAre("Straight on, then 8 steps.",
                                           "Turn left, then 4 steps to the microwave."));
}

TEST_F(RoutePromptsTest, CutCornersAreNoLegs) {
  const Route route{Vector2d(0, 0), Vector2d(3, 0), Vector2d(3.2, 0.2), Vector2d(3.2, 3)};
  EXPECT_THAT(words(route, 0), ElementsAre("Straight on, then 7 steps.",
                                           "Turn left, then 6 steps to the microwave."));
}

TEST_F(RoutePromptsTest, AtTheGoalAndWithoutAWay) {
  EXPECT_THAT(words(Route{Vector2d(0, 0), Vector2d(0.3, 0)}, 0),
              ElementsAre("You are at the microwave."));
  EXPECT_THAT(words(Route{Vector2d(0, 0)}, 0), ElementsAre("You are at the microwave."));
  EXPECT_EQ(no_route_prompt(true, "because", wording_, 0).text, "I know no safe way there.");
  EXPECT_EQ(no_route_prompt(false, "because", wording_, 0).text,
            "I do not know where you stand. Turn slowly.");
}

}  // namespace
}  // namespace roomwise::guide
