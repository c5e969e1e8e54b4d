#include "laboratory/simulation/render/light_bake.h"

#include <gmock/gmock.h>

#include <cmath>

#include "laboratory/simulation/scene/color_math.h"
#include "laboratory/simulation/testing/test_homes.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::simulation {
namespace {

class LightBakeTest : public ::testing::Test {
 protected:
  // The scene of a home whose objects are all boxes.
  static Scene scene_of(const HomeModel& home) {
    const auto box = std::make_shared<const TriangleMesh>(
        box_mesh(Eigen::Vector3f(0.6F, 0.5F, 0.8F), SurfaceMaterial{}));
    auto scene = Scene::build(home, std::vector(home.objects.size(), box));
    EXPECT_TRUE(scene.has_value());
    return std::move(*scene);
  }
  // The illuminance of the floor at a place.
  static Eigen::Vector3f on_floor(const Scene& scene, const BakedLight& light, float x, float y) {
    const Eigen::Vector3f down = -Eigen::Vector3f::UnitZ(), eye(x, y, 0.5F);
    const auto hit = scene.rays().first_hit(eye, down, 0, 10, RayCaster::Meets::kOpaque);
    EXPECT_TRUE(hit.has_value());
    return light.at(scene, *hit, eye + hit->distance * down, down);
  }
  Expected<BakedLight> bake(const HomeModel& home, const Scene& scene, double effort = 0.5) {
    const Emitters emitters(home, scene, effort);
    return bake_light(scene, emitters, effort, pool_, progress_, statistics_);
  }
  ThreadPool pool_{2};
  SilentProgress progress_;
  BakeStatistics statistics_;
};

// Black walls send nothing back, so that the formulas of direct light hold alone.
HomeModel black_room() {
  HomeModel home = square_rooms(1);
  home.rooms[0].floor = home.rooms[0].walls = home.rooms[0].ceiling = plain_finish(0);
  return home;
}

TEST_F(LightBakeTest, SmallLampLightsByTheInverseSquareAndTheCosine) {
  HomeModel home = black_room();
  Light lamp;
  lamp.position = {2, 2, 1.5};
  lamp.radius_m = 0.02;
  lamp.lumens = 1000;
  lamp.color_temperature_k = 6500;
  lamp.is_on = true;
  home.lights.push_back(lamp);
  const Scene scene = scene_of(home);
  const auto light = bake(home, scene);
  ASSERT_OK(light);
  for (const double x : {2.0, 2.5, 3.0, 3.5}) {
    const double squared = (x - 2) * (x - 2) + 1.5 * 1.5;
    const double expected = 1000 / (4 * std::numbers::pi) * 1.5 / std::pow(squared, 1.5);
    EXPECT_NEAR(luminance(on_floor(scene, *light, static_cast<float>(x), 2)), expected,
                0.04 * expected);
  }
}

TEST_F(LightBakeTest, PanelLightsLikeALambertianSurface) {
  HomeModel home = black_room();
  home.lights.push_back(ceiling_panel({2, 2}, 2000));
  const Scene scene = scene_of(home);
  const auto light = bake(home, scene);
  ASSERT_OK(light);
  // Far away it is a point whose intensity falls with the cosine: lumens / pi straight down.
  const double height = 2.567;
  for (const double x : {2.0, 3.0, 3.6}) {
    const double squared = (x - 2) * (x - 2) + height * height;
    const double expected = 2000 / std::numbers::pi * height * height / (squared * squared);
    EXPECT_NEAR(luminance(on_floor(scene, *light, static_cast<float>(x), 2)), expected,
                0.06 * expected);
  }
}

TEST_F(LightBakeTest, TwoBouncesBrightenAWhiteRoomAsMuchAsTheyShould) {
  HomeModel home = square_rooms(1);
  home.lights.push_back(ceiling_panel({2, 2}, 2000));
  const Scene white = scene_of(home);
  const auto light = bake(home, white);
  ASSERT_OK(light);
  HomeModel black = black_room();
  black.lights = home.lights;
  const Scene dark = scene_of(black);
  const auto direct = bake(black, dark);
  ASSERT_OK(direct);
  // All light that surfaces take is what the panel sends and what two bounces send back: with
  // albedo r the sum over the room is 1 + r + r^2 (a little light goes to the panel's rim).
  const auto total = [](const Scene& scene, const BakedLight& baked) {
    double sum = 0;
    for (const Patch& patch : scene.patches()) {
      const double area = static_cast<double>(patch.texel_width_m() * patch.texel_height_m());
      const auto count = static_cast<std::size_t>(patch.columns * patch.rows);
      for (std::size_t i = 0; i < count; ++i) {
        sum += area * static_cast<double>(luminance(baked.texels[patch.first_texel + i]));
      }
    }
    return sum;
  };
  const double r = static_cast<double>(linear_from_srgb(200));
  EXPECT_NEAR(total(dark, *direct), 2000, 0.05 * 2000);
  EXPECT_NEAR(total(white, *light) / total(dark, *direct), 1 + r + r * r, 0.08 * (1 + r + r * r));
}

TEST_F(LightBakeTest, LightDoesNotLeakThroughWalls) {
  HomeModel home = square_rooms(2);
  home.doors.clear();
  home.lights.push_back(ceiling_panel({2, 2}, 2000));
  home.objects.push_back(box_object({6, 2, 0}));
  const Scene scene = scene_of(home);
  const auto light = bake(home, scene, 0.2);
  ASSERT_OK(light);
  EXPECT_GT(luminance(on_floor(scene, *light, 2, 2)), 10);
  for (const float x : {4.15F, 4.3F, 5.0F, 7.0F}) {
    EXPECT_EQ(luminance(on_floor(scene, *light, x, 2)), 0) << x;
  }
  for (const SceneTriangle& triangle : scene.triangles()) {
    if (triangle.object == 0) continue;
    for (const std::uint32_t corner : triangle.corners) {
      EXPECT_EQ(luminance(light->corners[0][corner]), 0);
      EXPECT_EQ(luminance(light->corners[1][corner]), 0);
    }
  }
}

TEST_F(LightBakeTest, OpenDoorLetsLightIntoTheNextRoom) {
  HomeModel home = square_rooms(2);
  home.lights.push_back(ceiling_panel({2, 2}, 2000));
  const Scene scene = scene_of(home);
  const auto light = bake(home, scene, 0.2);
  ASSERT_OK(light);
  EXPECT_GT(luminance(on_floor(scene, *light, 4.6F, 2)),
            luminance(on_floor(scene, *light, 4.6F, 0.3F)));
  EXPECT_GT(luminance(on_floor(scene, *light, 4.6F, 0.3F)), 0);
}

TEST_F(LightBakeTest, BoxIsLitOnTheSideOfTheLampAndDarkerBehind) {
  HomeModel home = square_rooms(1);
  home.lights.push_back(ceiling_panel({0.8, 2}, 2000));
  home.objects.push_back(box_object({2.5, 2, 0}));
  const Scene scene = scene_of(home);
  const auto light = bake(home, scene);
  ASSERT_OK(light);
  const auto side_light = [&](float from, float towards) {
    const Eigen::Vector3f direction = Eigen::Vector3f::UnitX() * towards, eye(from, 2, 0.4F);
    const auto hit = scene.rays().first_hit(eye, direction, 0, 10, RayCaster::Meets::kOpaque);
    return luminance(light->at(scene, *hit, eye + hit->distance * direction, direction));
  };
  EXPECT_GT(side_light(1, 1), 2 * side_light(3.8F, -1));
}

// A box whose inner panels touch the outer ones: what lies between must not darken what is seen.
TEST_F(LightBakeTest, WhatIsBuriedDoesNotDarkenWhatIsSeen) {
  HomeModel home = square_rooms(1);
  home.lights.push_back(ceiling_panel({0.8, 2}, 2000));
  home.objects.push_back(box_object({2.5, 2, 0}));
  const Scene plain = scene_of(home);
  const auto expected = bake(home, plain);
  TriangleMesh nested = box_mesh(Eigen::Vector3f(0.6F, 0.5F, 0.8F), SurfaceMaterial{});
  const TriangleMesh inner = box_mesh(Eigen::Vector3f(0.59F, 0.49F, 0.79F), SurfaceMaterial{});
  const auto first = static_cast<std::uint32_t>(nested.positions.size());
  nested.positions.insert(nested.positions.begin(), inner.positions.begin(), inner.positions.end());
  nested.normals.insert(nested.normals.begin(), inner.normals.begin(), inner.normals.end());
  nested.texture_coordinates.insert(nested.texture_coordinates.begin(),
                                    inner.texture_coordinates.begin(),
                                    inner.texture_coordinates.end());
  for (TriangleMesh::Triangle& triangle : nested.triangles) {
    for (std::uint32_t& corner : triangle.corners) corner += first;
  }
  nested.triangles.insert(nested.triangles.begin(), inner.triangles.begin(), inner.triangles.end());
  const std::vector<std::shared_ptr<const TriangleMesh>> meshes{
      std::make_shared<const TriangleMesh>(nested)};
  const auto scene = Scene::build(home, meshes);
  ASSERT_OK(scene);
  const auto light = bake(home, *scene);
  ASSERT_OK(light);
  ASSERT_OK(expected);
  const auto front = [](const Scene& in, const BakedLight& baked, float z) {
    const Eigen::Vector3f direction = Eigen::Vector3f::UnitX(), eye(1, 2, z);
    const auto hit = in.rays().first_hit(eye, direction, 0, 10, RayCaster::Meets::kOpaque);
    return luminance(baked.at(in, *hit, eye + hit->distance * direction, direction));
  };
  for (const float z : {0.2F, 0.4F, 0.6F}) {
    EXPECT_NEAR(front(*scene, *light, z), front(plain, *expected, z),
                0.1F * front(plain, *expected, z));
  }
}

}  // namespace
}  // namespace roomwise::simulation
