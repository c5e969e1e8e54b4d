#include "laboratory/simulation/home/home_generator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "laboratory/simulation/home/bare_halls.h"
#include "laboratory/simulation/home/furnishing_rules.h"
#include "laboratory/simulation/home/home_checks.h"
#include "laboratory/simulation/home/home_geometry.h"
#include "laboratory/simulation/home/scenario.h"
#include "laboratory/simulation/testing/made_up_furniture.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::simulation {
namespace {

const std::vector<FurnitureModel>& models() {
  static const auto models = testing::made_up_furniture();
  return models;
}

bool is_same_place(const PlacedObject& a, const PlacedObject& b) {
  return a.world_from_object.translation == b.world_from_object.translation &&
         a.world_from_object.rotation.coeffs() == b.world_from_object.rotation.coeffs();
}

bool is_same_home(const HomeModel& a, const HomeModel& b) {
  return a.rooms.size() == b.rooms.size() &&
         std::ranges::equal(a.objects, b.objects, [](const auto& x, const auto& y) {
           return x.name == y.name && x.model == y.model && is_same_place(x, y);
         });
}

const PlacedObject* find(const HomeModel& home, const std::string& name) {
  const auto object = std::ranges::find(home.objects, name, &PlacedObject::name);
  return object == home.objects.end() ? nullptr : &*object;
}

class HomesOfSeeds : public ::testing::TestWithParam<std::uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Sample, HomesOfSeeds, ::testing::Range<std::uint64_t>(100, 120));

TEST_P(HomesOfSeeds, AreRightByDayAndWithThingsMoved) {
  const auto home = generate_home({GetParam(), {}}, models());
  ASSERT_OK(home);
  EXPECT_THAT(find_faults(*home), ::testing::IsEmpty());
  const HomeModel moved = apply_scenario(*home, Scenario::kMoved, GetParam() + 1, models());
  EXPECT_THAT(find_faults(moved), ::testing::IsEmpty());
}

TEST_P(HomesOfSeeds, AreRightWithBareHalls) {
  const auto home = generate_home({GetParam(), {}}, models());
  ASSERT_OK(home);
  const HomeModel bare = with_bare_halls(*home);
  EXPECT_THAT(find_faults(bare), ::testing::IsEmpty());
  const auto is_in_hall = [&](const auto& thing) {
    return bare.rooms[thing.room].kind == RoomKind::kHall;
  };
  EXPECT_TRUE(std::ranges::none_of(bare.objects, is_in_hall));
  EXPECT_TRUE(std::ranges::none_of(bare.pictures, is_in_hall));
  for (const PlacedObject& object : home->objects) {
    const PlacedObject* kept = find(bare, object.name);
    EXPECT_EQ(kept == nullptr, home->rooms[object.room].kind == RoomKind::kHall) << object.name;
    if (kept == nullptr || !object.stands_on) continue;
    EXPECT_EQ(bare.objects[*kept->stands_on].name, home->objects[*object.stands_on].name);
  }
  for (const Light& light : bare.lights) {
    if (!light.object) continue;
    EXPECT_EQ(bare.objects[*light.object].room, light.room);
  }
}

TEST(GenerateHome, GivesTheSameHomeForTheSameSeed) {
  const auto a = generate_home({7, {}}, models());
  const auto b = generate_home({7, {}}, models());
  const auto c = generate_home({8, {}}, models());
  ASSERT_OK(a);
  ASSERT_OK(b);
  ASSERT_OK(c);
  EXPECT_TRUE(is_same_home(*a, *b));
  EXPECT_FALSE(is_same_home(*a, *c));
}

TEST(GenerateHome, RoomsHaveWhatBelongsToThem) {
  std::size_t wanted = 0, there = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const auto home = generate_home({seed, {}}, models());
    ASSERT_OK(home);
    for (std::size_t room = 0; room < home->rooms.size(); ++room) {
      for (const std::string_view kind : essential_kinds(home->rooms[room].kind)) {
        ++wanted;
        there += std::ranges::any_of(home->objects, [&](const PlacedObject& object) {
          return object.room == room && object.kind == kind;
        });
      }
    }
  }
  // A small room may lack a wardrobe; hardly any does.
  EXPECT_GE(there, wanted * 97 / 100) << "of " << wanted;
}

TEST(GenerateHome, EveryRoomHasACeilingLightAndEveryLampItsOwn) {
  const auto home = generate_home({5, {}}, models());
  ASSERT_OK(home);
  for (std::size_t room = 0; room < home->rooms.size(); ++room) {
    EXPECT_TRUE(std::ranges::any_of(home->lights, [&](const Light& light) {
      return light.room == room && light.is_ceiling_panel;
    }));
  }
  for (std::size_t i = 0; i < home->objects.size(); ++i) {
    if (home->objects[i].kind != "lamp") continue;
    const auto light = std::ranges::find(home->lights, std::optional(i), &Light::object);
    ASSERT_NE(light, home->lights.end());
    EXPECT_TRUE(footprint_of(home->objects[i]).contains(light->position.head<2>()));
  }
}

TEST(GenerateHome, NothingStandsBeforeAMicrowavesDoor) {
  std::size_t neighbours = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const auto home = generate_home({seed, {RoomKind::kKitchen}}, models());
    ASSERT_OK(home);
    for (const PlacedObject& microwave : home->objects) {
      if (microwave.kind != "microwave") continue;
      for (const PlacedObject& other : home->objects) {
        if (other.stands_on != microwave.stands_on || other.name == microwave.name) continue;
        ++neighbours;
        const Eigen::Vector3d place =
            microwave.world_from_object.inverse() * other.world_from_object.translation;
        EXPECT_FALSE(place.y() < 0 && std::abs(place.x()) < microwave.size_m.x() / 2)
            << seed << ": " << other.name;
      }
    }
  }
  EXPECT_GT(neighbours, 0U);
}

TEST(GenerateHome, LeavesOutKindsWithoutModels) {
  const auto home = generate_home({5, {}}, std::span<const FurnitureModel>());
  ASSERT_OK(home);
  EXPECT_THAT(home->objects, ::testing::IsEmpty());
}

TEST(ReferenceFlat, HasTheSevenOnceEach) {
  const auto flat = reference_flat(models());
  ASSERT_OK(flat);
  EXPECT_THAT(find_faults(*flat), ::testing::IsEmpty());
  std::set<RoomKind> kinds;
  for (const Room& room : flat->rooms) kinds.insert(room.kind);
  EXPECT_THAT(kinds, ::testing::UnorderedElementsAre(RoomKind::kBedroom, RoomKind::kKitchen,
                                                     RoomKind::kToilet, RoomKind::kHall));
  ASSERT_EQ(reference_kinds().size(), 7);
  for (const std::string_view kind : reference_kinds()) {
    EXPECT_EQ(std::ranges::count(flat->objects, kind, &PlacedObject::kind), 1) << kind;
  }
}

TEST(ReferenceFlat, NeedsAModelOfEach) {
  std::vector<FurnitureModel> without = models();
  std::erase_if(without, [](const FurnitureModel& model) { return model.kind == "stove"; });
  EXPECT_ERROR(reference_flat(without), "needs a stove");
}

TEST(Scenarios, NightHasNoSunAndALightInEveryRoom) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const auto home = generate_home({seed, {}}, models());
    ASSERT_OK(home);
    EXPECT_TRUE(home->sun_direction);
    EXPECT_NEAR(home->sun_direction->norm(), 1, 1e-9);
    EXPECT_GT(home->sun_direction->z(), 0.4);
    for (const Scenario scenario : {Scenario::kNight, Scenario::kMovedNight}) {
      const HomeModel night = apply_scenario(*home, scenario, seed, models());
      EXPECT_EQ(night.scenario, scenario);
      EXPECT_FALSE(night.sun_direction);
      for (std::size_t room = 0; room < night.rooms.size(); ++room) {
        EXPECT_TRUE(std::ranges::any_of(
            night.lights, [&](const Light& light) { return light.room == room && light.is_on; }));
      }
    }
  }
}

TEST(Scenarios, EveningsSunIsLow) {
  int with_sun = 0;
  const auto home = generate_home({3, {}}, models());
  ASSERT_OK(home);
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const HomeModel evening = apply_scenario(*home, Scenario::kEvening, seed, models());
    EXPECT_TRUE(is_same_home(*home, evening));
    if (!evening.sun_direction) continue;
    ++with_sun;
    EXPECT_LT(evening.sun_direction->z(), 0.3);
    EXPECT_GT(evening.sun_direction->z(), 0);
  }
  EXPECT_GT(with_sun, 0);
  EXPECT_LT(with_sun, 20);
}

TEST(Scenarios, MovedLeavesLargeFurnitureAndMovesTheRest) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const auto home = generate_home({seed, {}}, models());
    ASSERT_OK(home);
    const HomeModel moved = apply_scenario(*home, Scenario::kMoved, 1, models());
    int changed = 0, gone = 0, added = 0;
    for (const PlacedObject& before : home->objects) {
      const PlacedObject* after = find(moved, before.name);
      const bool may_change = before.is_small || before.is_movable;
      if (after == nullptr) {
        EXPECT_TRUE(may_change) << before.name;
        ++gone;
      } else if (!is_same_place(before, *after)) {
        EXPECT_TRUE(may_change) << before.name;
        EXPECT_EQ(before.model, after->model);
        ++changed;
      }
    }
    for (const PlacedObject& after : moved.objects) added += find(*home, after.name) == nullptr;
    EXPECT_GT(changed, 4) << "seed " << seed;
    EXPECT_GT(gone + added, 0) << "seed " << seed;
    for (const Light& light : moved.lights) {
      if (!light.object) continue;
      EXPECT_EQ(moved.objects[*light.object].kind.find("lamp") != std::string::npos, true);
      EXPECT_TRUE(footprint_of(moved.objects[*light.object]).contains(light.position.head<2>()));
    }
  }
}

TEST(Scenarios, MovedIsTheSameForTheSameSeed) {
  const auto home = generate_home({4, {}}, models());
  ASSERT_OK(home);
  const HomeModel a = apply_scenario(*home, Scenario::kMoved, 1, models());
  const HomeModel b = apply_scenario(*home, Scenario::kMovedNight, 1, models());
  const HomeModel c = apply_scenario(*home, Scenario::kMoved, 2, models());
  EXPECT_TRUE(is_same_home(a, b));  // by night the same things have moved
  EXPECT_FALSE(is_same_home(a, c));
}

}  // namespace
}  // namespace roomwise::simulation
