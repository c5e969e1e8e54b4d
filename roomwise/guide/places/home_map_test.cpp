#include "roomwise/guide/places/home_map.h"

#include <gtest/gtest.h>

#include "roomwise/guide/testing/drawn_floor.h"

namespace roomwise::guide {
namespace {

// Bedroom left of x = 4 m, kitchen right of 4.1 m, the door from y = 3 m to 3.9 m.
class InRoomTest : public ::testing::Test {
 protected:
  [[nodiscard]] bool is_inside(const std::string& room, double x, double y) const {
    return is_well_inside({&grid, &layout, layout.doorways(), {}}, room, {x, y});
  }

  const fusion::FloorGrid grid = testing::two_rooms().grid();
  const rooms::RoomLayout layout = testing::layout_of_two_rooms(grid);
};

TEST_F(InRoomTest, WhoStandsAmidARoomIsInItAndInNoOther) {
  EXPECT_TRUE(is_inside("bedroom", 2, 2));
  EXPECT_FALSE(is_inside("kitchen", 2, 2));
  EXPECT_TRUE(is_inside("kitchen", 6, 2));
  EXPECT_FALSE(is_inside("bedroom", 6, 2));
  EXPECT_FALSE(is_inside("attic", 2, 2));
}

TEST_F(InRoomTest, WhoStandsInADoorsFrameIsInNeitherRoom) {
  for (const double x : {3.85, 4.05, 4.2}) {
    EXPECT_FALSE(is_inside("bedroom", x, 3.45)) << x;
    EXPECT_FALSE(is_inside("kitchen", x, 3.45)) << x;
  }
}

TEST_F(InRoomTest, ABodysWidthFromTheBorderTheyAreInTheRoom) {
  EXPECT_TRUE(is_inside("bedroom", 3.7, 3.45));
  EXPECT_TRUE(is_inside("kitchen", 4.4, 3.45));
}

TEST_F(InRoomTest, WallsAreOfNoOtherRoom) {
  EXPECT_TRUE(is_inside("bedroom", 3.7, 1)) << "before the wall between the rooms";
  EXPECT_TRUE(is_inside("bedroom", 0.2, 0.2)) << "in the corner";
}

TEST_F(InRoomTest, NobodyIsInARoomOutsideOfAll) {
  EXPECT_FALSE(is_inside("bedroom", -3, 2));
  const HomeMap nothing;
  EXPECT_FALSE(is_well_inside(nothing, "bedroom", {2, 2}));
}

}  // namespace
}  // namespace roomwise::guide
