#include "laboratory/simulation/walk/walk.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "laboratory/simulation/home/free_space.h"
#include "laboratory/simulation/home/home_generator.h"
#include "laboratory/simulation/home/home_geometry.h"
#include "laboratory/simulation/home/scenario.h"
#include "laboratory/simulation/testing/made_up_furniture.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::simulation {
namespace {

HomeModel home_of(std::uint64_t seed) {
  return *generate_home({seed, {}}, testing::made_up_furniture());
}

// How near a place is to a wall, a leaf or a thing.
double exact_clearance(const HomeModel& home, const Eigen::Vector2d& place) {
  double least = 1e9;
  for (const Footprint& obstacle : obstacles_of(home, kBodyFromHeight, kBodyToHeight)) {
    least = std::min(least, obstacle.distance_m(place));
  }
  const auto floors = floors_of(home);
  constexpr int kDirections = 32;
  for (int i = 0; i < kDirections; ++i) {
    const double angle = 2 * 3.14159265358979 * i / kDirections;
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    for (double distance = 0; distance < std::min(least, 1.0); distance += 0.01) {
      const Eigen::Vector2d point = place + distance * direction;
      const bool is_floor = std::ranges::any_of(
          floors, [&](const Rectangle& floor) { return contains(floor, point); });
      if (!is_floor) least = std::min(least, distance);
    }
  }
  return least;
}

// Whether the middle of an object is in a picture of usual width from 1 to 2.4 m.
bool sees(const WalkPose& pose, const PlacedObject& object) {
  const Eigen::Vector3d middle =
      object.world_from_object * Eigen::Vector3d(0, 0, object.size_m.z() / 2);
  const Eigen::Vector3d seen = pose.world_from_camera.inverse() * middle;
  const double away = (middle - pose.world_from_camera.translation).head<2>().norm();
  return seen.z() > 0 && std::abs(seen.x()) < 0.55 * seen.z() &&
         std::abs(seen.y()) < 0.42 * seen.z() && away > 0.9 && away < 2.5;
}

TEST(Walk, StaysClearVisitsEveryRoomAndComesBack) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    HomeModel home = home_of(seed);
    if (seed % 2 == 1) {
      home = apply_scenario(home, Scenario::kMoved, seed, testing::made_up_furniture());
    }
    WalkOptions options;
    options.seed = seed;
    const auto walk = plan_walk(home, options);
    ASSERT_OK(walk);
    std::set<std::size_t> rooms;
    for (const WalkPose& pose : *walk) {
      rooms.insert(pose.room);
      const Eigen::Vector3d& place = pose.world_from_camera.translation;
      EXPECT_GE(exact_clearance(home, place.head<2>()), 0.25) << "seed " << seed;
      EXPECT_NEAR(place.z(), options.camera_height_m, 0.06);
    }
    EXPECT_EQ(rooms.size(), home.rooms.size());
    const auto back = walk->front().world_from_camera.inverse() * walk->back().world_from_camera;
    EXPECT_LT(back.distance_m(), 0.1);
    EXPECT_LT(back.angle_rad(), 0.2);
  }
}

TEST(Walk, MovesAsPeopleDo) {
  const HomeModel home = home_of(2);
  WalkOptions options;
  options.frames_per_second = 50;
  options.fast_turns = false;
  const auto walk = plan_walk(home, options);
  ASSERT_OK(walk);
  double farthest_down = 0, level = 0;
  for (std::size_t i = 1; i < walk->size(); ++i) {
    const WalkPose &a = (*walk)[i - 1], &b = (*walk)[i];
    EXPECT_EQ(b.timestamp_ns - a.timestamp_ns, 20'000'000);
    const auto a_from_b = a.world_from_camera.inverse() * b.world_from_camera;
    // The hand adds its shaking to the body's limits.
    EXPECT_LT(a_from_b.distance_m() * 50, options.walking_speed_m_s + 0.25);
    EXPECT_LT(a_from_b.angle_rad() * 50, options.max_turning_rad_s + 0.35);
    const Eigen::Vector3d forward = b.world_from_camera.rotation * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d right = b.world_from_camera.rotation * Eigen::Vector3d::UnitX();
    EXPECT_LT(std::abs(right.z()), 0.06);  // upright
    farthest_down = std::max(farthest_down, -std::asin(forward.z()));
    level += std::asin(-forward.z()) / static_cast<double>(walk->size());
  }
  EXPECT_LT(farthest_down, 0.6);
  EXPECT_GT(level, 0.08);
  EXPECT_LT(level, 0.35);
}

TEST(Walk, TurnsFastNowAndThenIfAllowed) {
  const HomeModel home = home_of(2);
  const auto fastest = [&](bool fast_turns) {
    WalkOptions options;
    options.fast_turns = fast_turns;
    options.jitter = 0;
    const auto walk = plan_walk(home, options);
    double most = 0;
    for (std::size_t i = 1; walk && i < walk->size(); ++i) {
      most = std::max(
          most,
          ((*walk)[i - 1].world_from_camera.inverse() * (*walk)[i].world_from_camera).angle_rad() *
              5);
    }
    return most;
  };
  EXPECT_GT(fastest(true), 1.5);
  EXPECT_LT(fastest(false), 1.1);
}

TEST(Walk, ShowsTheLargeObjects) {
  std::size_t large = 0, seen = 0;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const HomeModel home = home_of(seed);
    const auto walk = plan_walk(home, {});
    ASSERT_OK(walk);
    for (const PlacedObject& object : home.objects) {
      const bool stands = object.world_from_object.translation.z() < 0.1;
      if (object.is_small || object.is_movable || !stands || object.size_m.z() < 0.4) continue;
      ++large;
      seen += std::ranges::any_of(*walk, [&](const WalkPose& pose) { return sees(pose, object); });
    }
  }
  EXPECT_GE(seen, large * 97 / 100) << "of " << large;
}

TEST(Walk, ShowsTheSevenOfTheReferenceFlatSeveralTimes) {
  const auto flat = reference_flat(testing::made_up_furniture());
  ASSERT_OK(flat);
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    WalkOptions options;
    options.seed = seed;
    const auto walk = plan_walk(*flat, options);
    ASSERT_OK(walk);
    for (const std::string_view kind : reference_kinds()) {
      const auto object = std::ranges::find(flat->objects, kind, &PlacedObject::kind);
      const auto frames =
          std::ranges::count_if(*walk, [&](const WalkPose& pose) { return sees(pose, *object); });
      EXPECT_GE(frames, 3) << kind << ", seed " << seed;
    }
  }
}

TEST(Walk, IsTheSameForTheSameSeed) {
  const HomeModel home = home_of(1);
  const auto walk_of = [&](std::uint64_t seed) {
    WalkOptions options;
    options.seed = seed;
    return *plan_walk(home, options);
  };
  const auto same = [](const std::vector<WalkPose>& a, const std::vector<WalkPose>& b) {
    return std::ranges::equal(a, b, [](const WalkPose& x, const WalkPose& y) {
      return x.world_from_camera.translation == y.world_from_camera.translation &&
             x.world_from_camera.rotation.coeffs() == y.world_from_camera.rotation.coeffs();
    });
  };
  EXPECT_TRUE(same(walk_of(1), walk_of(1)));
  EXPECT_FALSE(same(walk_of(1), walk_of(2)));
}

TEST(Walk, TheShutterIsOpenAroundTheFrame) {
  const auto walk = plan_walk(home_of(1), {});
  ASSERT_OK(walk);
  double farthest = 0;
  for (const WalkPose& pose : *walk) {
    const auto blur = pose.world_from_camera_open.inverse() * pose.world_from_camera_close;
    const auto half = pose.world_from_camera_open.inverse() * pose.world_from_camera;
    EXPECT_LE(half.angle_rad(), blur.angle_rad() + 1e-3);
    farthest = std::max(farthest, blur.angle_rad());
  }
  EXPECT_GT(farthest, 0.01);  // a turn blurs
  EXPECT_LT(farthest, 0.1);
}

TEST(Walk, GoesWhereItIsTold) {
  const HomeModel home = home_of(1);
  WalkOptions options;
  options.rooms = {"kitchen", "bedroom"};
  options.max_frames = 200;
  const auto walk = plan_walk(home, options);
  ASSERT_OK(walk);
  EXPECT_EQ(walk->size(), 200);
  EXPECT_EQ(home.rooms[walk->front().room].name, "kitchen");
  options.rooms = {"cellar"};
  EXPECT_ERROR(plan_walk(home, options), "no room 'cellar'");
}

TEST(Walk, TellsWhenARoomCannotBeReached) {
  HomeModel home = home_of(1);
  for (Door& door : home.doors) {
    if (door.other_room) {
      door.has_leaf = true;
      door.open_rad = 0;
    }
  }
  EXPECT_ERROR(plan_walk(home, {}), "cannot be reached");
}

TEST(WalkOptions, AreChecked) {
  const HomeModel home = home_of(1);
  WalkOptions options;
  options.frames_per_second = 0;
  EXPECT_ERROR(plan_walk(home, options), "frames_per_second = 0");
  options = {};
  options.camera_height_m = 3;
  EXPECT_ERROR(plan_walk(home, options), "camera_height_m = 3");
}

}  // namespace
}  // namespace roomwise::simulation
