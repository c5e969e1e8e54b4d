#include "laboratory/simulation/home/twins.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "laboratory/simulation/home/home_checks.h"
#include "laboratory/simulation/home/home_generator.h"
#include "laboratory/simulation/testing/made_up_furniture.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::simulation {
namespace {

HomeModel twin(const HomeOptions& options) {
  static const auto models = testing::made_up_furniture();
  return generate_home(options, models).value();
}

bool has_same_plan(const HomeModel& a, const HomeModel& b) {
  return std::ranges::equal(a.rooms, b.rooms,
                            [](const Room& one, const Room& other) {
                              return one.name == other.name &&
                                     one.interior.min == other.interior.min &&
                                     one.interior.max == other.interior.max;
                            }) &&
         std::ranges::equal(a.doors, b.doors, [](const Door& one, const Door& other) {
           return one.opening.center == other.opening.center && one.room == other.room;
         });
}

bool has_same_finishes(const HomeModel& a, const HomeModel& b) {
  return std::ranges::equal(a.rooms, b.rooms, [](const Room& one, const Room& other) {
    return one.walls.seed == other.walls.seed && one.floor.seed == other.floor.seed;
  });
}

bool has_same_furniture(const HomeModel& a, const HomeModel& b) {
  return std::ranges::equal(
      a.objects, b.objects, [](const PlacedObject& one, const PlacedObject& other) {
        return one.model == other.model &&
               one.world_from_object.translation == other.world_from_object.translation;
      });
}

TEST(Twins, ShareTheirPlanAndNoMoreThanIsSaid) {
  const HomeModel home = twin({3, {}});
  const HomeModel refurnished = twin({.seed = 3, .rooms = {}, .furniture_seed = 4});
  EXPECT_TRUE(has_same_plan(home, refurnished));
  EXPECT_TRUE(has_same_finishes(home, refurnished));
  EXPECT_FALSE(has_same_furniture(home, refurnished));
  const HomeModel repainted = twin({.seed = 3, .rooms = {}, .finish_seed = 4});
  EXPECT_TRUE(has_same_plan(home, repainted));
  EXPECT_FALSE(has_same_finishes(home, repainted));
  EXPECT_TRUE(has_same_furniture(home, repainted));
}

TEST(Twins, MirroredHomesAreRightAndMirroredAgainTheyAreTheHome) {
  for (std::uint64_t seed = 100; seed < 110; ++seed) {
    const HomeModel home = twin({seed, {}});
    const HomeModel other = twin({.seed = seed, .rooms = {}, .mirrored = true});
    EXPECT_THAT(find_faults(other), ::testing::IsEmpty());
    EXPECT_FALSE(has_same_plan(home, other)) << seed;
    ASSERT_EQ(home.rooms.size(), other.rooms.size());
    for (std::size_t room = 0; room < home.rooms.size(); ++room) {
      const auto size = [&](const HomeModel& one) {
        return (one.rooms[room].interior.max - one.rooms[room].interior.min).eval();
      };
      EXPECT_TRUE(size(home).isApprox(size(other), 1e-12));
    }
    const HomeModel back = mirrored(other);
    for (std::size_t door = 0; door < home.doors.size(); ++door) {
      EXPECT_TRUE(back.doors[door].opening.center.isApprox(home.doors[door].opening.center, 1e-12));
      EXPECT_EQ(back.doors[door].hinge_at_min, home.doors[door].hinge_at_min);
      EXPECT_EQ(back.doors[door].opens_to_positive, home.doors[door].opens_to_positive);
    }
    for (std::size_t window = 0; window < home.windows.size(); ++window) {
      EXPECT_EQ(back.windows[window].outside_is_positive, home.windows[window].outside_is_positive);
    }
  }
}

TEST(Twins, AreOfOneStorey) {
  EXPECT_ERROR((HomeOptions{.seed = 3, .rooms = {}, .storeys = 2, .mirrored = true}.validate()),
               "leave out");
  EXPECT_OK((HomeOptions{.seed = 3, .rooms = {}, .mirrored = true}.validate()));
}

}  // namespace
}  // namespace roomwise::simulation
