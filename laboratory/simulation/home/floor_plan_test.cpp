#include "laboratory/simulation/home/floor_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "laboratory/simulation/home/free_space.h"
#include "laboratory/simulation/home/home_geometry.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::simulation {
namespace {

constexpr std::uint64_t kSeeds = 40;

TEST(FloorPlan, HasThreeToEightRoomsOfPlausibleSize) {
  std::set<std::size_t> counts;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const auto home = plan_floor(seed, {});
    ASSERT_OK(home);
    counts.insert(home->rooms.size());
    EXPECT_EQ(std::ranges::count(home->rooms, RoomKind::kHall, &Room::kind), 1);
    for (const Room& room : home->rooms) {
      SCOPED_TRACE(::testing::Message() << "seed " << seed << ", " << room.name);
      const double area = area_m2(room.interior);
      const double narrow = size(room.interior).minCoeff();
      if (room.kind == RoomKind::kToilet) {
        EXPECT_THAT(area, ::testing::AllOf(::testing::Gt(3), ::testing::Lt(7.2)));
      }
      if (room.kind == RoomKind::kBedroom) {
        EXPECT_THAT(area, ::testing::AllOf(::testing::Gt(9), ::testing::Lt(18.5)));
      }
      if (room.kind == RoomKind::kHall) {
        EXPECT_GE(narrow, 1.3);
      }
    }
  }
  EXPECT_EQ(*counts.begin(), 3);
  EXPECT_EQ(*counts.rbegin(), 8);
}

TEST(FloorPlan, RoomsTileTheFootprint) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const auto home = plan_floor(seed, {});
    ASSERT_OK(home);
    const double half = home->wall_thickness_m / 2;
    Rectangle flat = home->rooms.front().interior;
    double sum = 0;
    for (const Room& room : home->rooms) {
      flat.min = flat.min.cwiseMin(room.interior.min);
      flat.max = flat.max.cwiseMax(room.interior.max);
      sum += (size(room.interior).array() + 2 * half).prod();
    }
    EXPECT_NEAR(sum, (size(flat).array() + 2 * half).prod(), 1e-6) << "seed " << seed;
    for (std::size_t i = 0; i < home->rooms.size(); ++i) {
      for (std::size_t j = i + 1; j < home->rooms.size(); ++j) {
        EXPECT_FALSE(overlap_on_floor(as_footprint(home->rooms[i].interior, 0, 1).grown(half),
                                      as_footprint(home->rooms[j].interior, 0, 1).grown(half),
                                      1e-6))
            << "seed " << seed;
      }
    }
  }
}

TEST(FloorPlan, AllRoomsCanBeReachedFromTheFrontDoor) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const auto home = plan_floor(seed, {});
    ASSERT_OK(home);
    const auto front =
        std::ranges::find_if(home->doors, [](const Door& door) { return !door.other_room; });
    ASSERT_NE(front, home->doors.end()) << "seed " << seed;
    const FreeSpace space = FreeSpace::of(*home);
    const auto start = space.nearest_free(front->opening.center, 0.3);
    ASSERT_TRUE(start);
    for (const Room& room : home->rooms) {
      EXPECT_TRUE(space.path(*start, center(room.interior), 0.3)) << "seed " << seed << room.name;
    }
  }
}

TEST(FloorPlan, WindowsLookOutside) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const auto home = plan_floor(seed, {});
    ASSERT_OK(home);
    EXPECT_FALSE(home->windows.empty());
    for (const Window& window : home->windows) {
      Eigen::Vector2d outside = window.opening.center;
      outside[window.opening.along_x ? 1 : 0] += window.outside_is_positive ? 0.3 : -0.3;
      for (const Room& room : home->rooms) EXPECT_FALSE(contains(room.interior, outside));
      const Eigen::Vector2d inside = 2 * window.opening.center - outside;
      EXPECT_EQ(room_at(*home, inside), window.room);
    }
  }
}

TEST(FloorPlan, TakesTheRoomsThatAreAskedFor) {
  const auto home = plan_floor(3, {RoomKind::kBedroom, RoomKind::kBedroom, RoomKind::kStudy});
  ASSERT_OK(home);
  std::vector<std::string> names;
  for (const Room& room : home->rooms) names.push_back(room.name);
  EXPECT_THAT(names, ::testing::UnorderedElementsAre("bedroom", "second bedroom", "study", "hall"));
}

TEST(FloorPlan, RefusesWhatIsNoFlat) {
  EXPECT_ERROR(plan_floor(1, {RoomKind::kHall}), "name more rooms");
  EXPECT_ERROR(plan_floor(1, std::vector<RoomKind>(4, RoomKind::kBedroom)), "too many");
  EXPECT_ERROR(plan_floor(1, {RoomKind::kHall, RoomKind::kHall, RoomKind::kStudy}), "too many");
}

TEST(RoomNames, AreReadBack) {
  for (const RoomKind kind : {RoomKind::kBedroom, RoomKind::kDiningRoom, RoomKind::kHall}) {
    const auto read = parse_room_kind(name_of(kind));
    ASSERT_OK(read);
    EXPECT_EQ(*read, kind);
  }
  EXPECT_EQ(*parse_room_kind("living-room"), RoomKind::kLivingRoom);
  EXPECT_EQ(*parse_scenario("moved-night"), Scenario::kMovedNight);
  EXPECT_ERROR(parse_room_kind("cellar"), "'cellar'");
  EXPECT_ERROR(parse_scenario("dawn"), "'dawn'");
}

}  // namespace
}  // namespace roomwise::simulation
