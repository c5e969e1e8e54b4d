#include "laboratory/simulation/render/renderer.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "laboratory/simulation/scene/color_math.h"
#include "laboratory/simulation/testing/test_homes.h"
#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::simulation {
namespace {

class RendererTest : public ::testing::Test {
 protected:
  static RenderOptions quick() {
    RenderOptions options;
    options.bake_effort = 0.15;
    return options;
  }
  std::unique_ptr<Renderer> render_home(const HomeModel& home, const RenderOptions& options,
                                        ThreadPool& pool) {
    auto renderer = Renderer::create(home, load_box, options, pool, progress_);
    EXPECT_TRUE(renderer.has_value()) << (renderer ? "" : renderer.error().message);
    return renderer ? std::move(*renderer) : nullptr;
  }
  std::unique_ptr<Renderer> render_home(const HomeModel& home) {
    return render_home(home, quick(), pool_);
  }
  ThreadPool pool_{2};
  SilentProgress progress_;
};

TEST_F(RendererTest, DepthOfAWallIsItsDistanceAlongTheAxis) {
  const auto renderer = render_home(square_rooms(1));
  geometry::PinholeCamera camera = small_camera();
  for (const bool is_distorted : {false, true}) {
    if (is_distorted) camera.distortion = {0.2624, -0.9531, -0.0054, 0.0026, 1.1633};
    const RenderedFrame frame = renderer->render(camera, level_view({1, 2, 1.3}, 0), pool_);
    // The middle rows see the wall x = 4 alone.
    for (int y = 20; y < 40; ++y) {
      for (int x = 20; x < 60; ++x) EXPECT_NEAR(frame.depth_m.at(x, y), 3, 1e-4) << x << ' ' << y;
    }
  }
}

TEST_F(RendererTest, DistortionMovesWhatIsSeen) {
  HomeModel home = square_rooms(1);
  home.objects.push_back(box_object({3, 2, 0}));
  const auto renderer = render_home(home);
  geometry::PinholeCamera camera = small_camera();
  camera.distortion = {0.2624, -0.9531, -0.0054, 0.0026, 1.1633};
  const geometry::RigidTransform world_from_camera = level_view({0.5, 1.6, 0.7}, 0.1);
  const RenderedFrame frame = renderer->render(camera, world_from_camera, pool_);
  // Every pixel's point, from its depth, lies on the pixel again and inside the room.
  for (int y = 0; y < camera.height; y += 7) {
    for (int x = 0; x < camera.width; x += 7) {
      const Eigen::Vector3d point =
          world_from_camera * camera.unproject({x, y}, frame.depth_m.at(x, y));
      const Eigen::Vector3d inside =
          point.cwiseMax(Eigen::Vector3d(0, 0, 0)).cwiseMin(Eigen::Vector3d(4, 4, 2.6));
      EXPECT_LT((point - inside).norm(), 1e-3);
      const double to_surface = std::min(
          {point.x(), 4 - point.x(), point.y(), 4 - point.y(), point.z(), 2.6 - point.z()});
      const bool is_box = frame.object.at(x, y) == 1;
      // The skirting board is 13 mm thick.
      EXPECT_TRUE(is_box || std::abs(to_surface) < 0.02) << x << ' ' << y;
    }
  }
}

TEST_F(RendererTest, KnownPointIsDrawnWhereItProjects) {
  HomeModel home = square_rooms(1);
  home.objects.push_back(box_object({2.5, 2.2, 0}));
  const auto renderer = render_home(home);
  const geometry::PinholeCamera camera = small_camera();
  const geometry::RigidTransform world_from_camera = level_view({0.5, 2.2, 1.0}, 0);
  const RenderedFrame frame = renderer->render(camera, world_from_camera, pool_);
  // The box's front face is at x = 2.2, from y = 1.95 to 2.45, z = 0 to 0.8. +y is to the left.
  const auto pixel_of = [&](const Eigen::Vector3d& world) {
    return camera.project(world_from_camera.inverse() * world);
  };
  const Eigen::Vector2d top_left = pixel_of({2.2, 2.45, 0.8}),
                        low_right = pixel_of({2.2, 1.95, 0.4});
  EXPECT_LT(top_left.x(), low_right.x());
  const auto object_at = [&](double x, double y) {
    return frame.object.at(static_cast<int>(std::lround(x)), static_cast<int>(std::lround(y)));
  };
  EXPECT_EQ(object_at(top_left.x() + 1, top_left.y() + 1), 1);
  EXPECT_EQ(object_at(top_left.x() - 1, top_left.y() + 1), 0);
  EXPECT_EQ(object_at(top_left.x() + 1, top_left.y() - 2), 0);
  EXPECT_EQ(object_at(low_right.x() - 1, low_right.y()), 1);
  EXPECT_EQ(object_at(low_right.x() + 1, low_right.y()), 0);
}

TEST_F(RendererTest, DoorLetsTheNextRoomBeSeen) {
  const auto renderer = render_home(square_rooms(2));
  const RenderedFrame frame = renderer->render(small_camera(), level_view({3, 2, 1.2}, 0), pool_);
  EXPECT_NEAR(frame.depth_m.at(40, 30), 5.12, 1e-3);  // the far wall of the second room
  EXPECT_NEAR(frame.depth_m.at(2, 30), 1, 1e-3);      // beside the door
}

TEST_F(RendererTest, DoorLeafTurnsAboutItsHinge) {
  HomeModel home = square_rooms(2);
  home.doors[0].has_leaf = true;
  home.doors[0].open_rad = 0;
  const geometry::RigidTransform view = level_view({2, 2, 1.2}, 0);
  const auto shut = render_home(home)->render(small_camera(), view, pool_);
  // Shut, its face lies in the face of the wall on the side that it opens to: x = 4.12, 4 cm thick.
  EXPECT_NEAR(shut.depth_m.at(44, 34), 2.09, 0.03);
  home.doors[0].open_rad = std::numbers::pi / 2;
  const auto open = render_home(home)->render(small_camera(), view, pool_);
  EXPECT_NEAR(open.depth_m.at(40, 30), 6.12, 1e-3);
}

TEST_F(RendererTest, FramesWarpIntoOneAnother) {
  HomeModel home = square_rooms(2);
  home.objects.push_back(box_object({2.8, 1.2, 0}));
  const auto renderer = render_home(home);
  const geometry::PinholeCamera camera = small_camera();
  const geometry::RigidTransform world_from_a = level_view({0.6, 1.5, 1.3}, 0.2);
  const geometry::RigidTransform world_from_b = level_view({0.7, 1.6, 1.35}, 0.12);
  const RenderedFrame a = renderer->render(camera, world_from_a, pool_);
  const RenderedFrame b = renderer->render(camera, world_from_b, pool_);
  std::vector<double> errors_m;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector3d point_b =
          world_from_b.inverse() * world_from_a * camera.unproject({x, y}, a.depth_m.at(x, y));
      const Eigen::Vector2d pixel = camera.project(point_b);
      const int left = static_cast<int>(std::floor(pixel.x()));
      const int top = static_cast<int>(std::floor(pixel.y()));
      if (!b.depth_m.contains(left, top) || !b.depth_m.contains(left + 1, top + 1)) continue;
      const double fx = pixel.x() - left, fy = pixel.y() - top;
      // Along a plane the inverse of depth is linear in the picture.
      const double inverse =
          (1 - fy) * ((1 - fx) / b.depth_m.at(left, top) + fx / b.depth_m.at(left + 1, top)) +
          fy * ((1 - fx) / b.depth_m.at(left, top + 1) + fx / b.depth_m.at(left + 1, top + 1));
      errors_m.push_back(std::abs(1 / inverse - point_b.z()));
    }
  }
  ASSERT_GT(errors_m.size(), 3000U);
  std::nth_element(errors_m.begin(),
                   errors_m.begin() + 2 * static_cast<std::ptrdiff_t>(errors_m.size()) / 3,
                   errors_m.end());
  EXPECT_LT(errors_m[2 * errors_m.size() / 3], 0.002);
}

TEST_F(RendererTest, NightWithoutLampsIsDarkAndALampIsNot) {
  HomeModel home = square_rooms(1);
  const geometry::RigidTransform view = level_view({0.5, 2, 1.3}, 0);
  const auto dark = render_home(home)->render(small_camera(), view, pool_);
  for (const Eigen::Vector3f& light : dark.radiance.pixels()) EXPECT_EQ(light.maxCoeff(), 0);
  home.lights.push_back(ceiling_panel({2, 2}, 2500));
  const auto lit = render_home(home)->render(small_camera(), view, pool_);
  EXPECT_GT(luminance(lit.radiance.at(40, 40)), 5);
}

TEST_F(RendererTest, ShadowIsDarkerThanLitFloor) {
  HomeModel home = square_rooms(1);
  home.lights.push_back(ceiling_panel({1, 2}, 2500));
  home.objects.push_back(box_object({2.5, 2, 0}));  // from x = 2.2 to 2.8
  const auto renderer = render_home(home);
  const geometry::PinholeCamera camera = small_camera();
  // From above the far wall, looking back at the floor: behind the box, and as far to the side.
  const Eigen::Vector3d eye(3.9, 2, 2.2), down(-0.6, 0, -0.8);
  Eigen::Matrix3d rotation;
  const Eigen::Vector3d right(0, 1, 0);
  rotation << right, down.cross(right), down;
  const auto view = geometry::RigidTransform::from_matrix(rotation, eye);
  const RenderedFrame frame = renderer->render(camera, view, pool_);
  const auto light_at = [&](const Eigen::Vector3d& world) {
    const Eigen::Vector2d pixel = camera.project(view.inverse() * world);
    return luminance(frame.radiance.at(static_cast<int>(std::lround(pixel.x())),
                                       static_cast<int>(std::lround(pixel.y()))));
  };
  EXPECT_LT(light_at({2.95, 2, 0}), 0.6F * light_at({2.95, 3.0, 0}));
}

TEST_F(RendererTest, SunDrawsAPatchOnTheFloor) {
  HomeModel home = square_rooms(1);
  home.scenario = Scenario::kDay;
  home.sun_direction = Eigen::Vector3d(1, 0, 1).normalized();
  Window window;
  window.opening = {{4.06, 2}, false, 1.2, 1.0, 2.2};
  home.windows.push_back(window);
  const auto renderer = render_home(home);
  const geometry::PinholeCamera camera = small_camera();
  const auto view = level_view({0.2, 2, 1.0}, 0);
  const RenderedFrame frame = renderer->render(camera, view, pool_);
  const auto light_at = [&](double x, double y) {
    const Eigen::Vector2d pixel = camera.project(view.inverse() * Eigen::Vector3d(x, y, 0));
    return luminance(frame.radiance.at(static_cast<int>(std::lround(pixel.x())),
                                       static_cast<int>(std::lround(pixel.y()))));
  };
  // Through the window (z from 1 to 2.2 at x = 4.06) at 45 degrees: the floor from x = 1.9 to 3.1.
  EXPECT_GT(light_at(2.5, 2.2), 4 * light_at(2.5, 3.2));
  EXPECT_GT(light_at(2.5, 2.2), 4 * light_at(3.6, 2.2));
}

TEST_F(RendererTest, SameBitsAtAnyNumberOfThreads) {
  HomeModel home = square_rooms(2);
  home.lights.push_back(ceiling_panel({1, 2}, 2500));
  home.objects.push_back(box_object({2.5, 2, 0}));
  ThreadPool one(1), three(3);
  const geometry::RigidTransform view = level_view({0.5, 1.2, 1.3}, 0.3);
  const auto a = render_home(home, quick(), one)->render(small_camera(), view, one);
  const auto b = render_home(home, quick(), three)->render(small_camera(), view, three);
  EXPECT_EQ(a.radiance, b.radiance);
  EXPECT_EQ(a.depth_m, b.depth_m);
  EXPECT_EQ(a.object, b.object);
  EXPECT_EQ(a.albedo, b.albedo);
  EXPECT_EQ(a.specularity, b.specularity);
}

TEST_F(RendererTest, KeptLightGivesTheSamePicture) {
  const testing::ScratchFolder folder;
  RenderOptions options = quick();
  options.light_cache = folder / "light";
  HomeModel home = square_rooms(1);
  home.lights.push_back(ceiling_panel({1, 2}, 2500));
  const geometry::RigidTransform view = level_view({0.5, 1.2, 1.3}, 0.3);
  const auto first = render_home(home, options, pool_);
  EXPECT_FALSE(first->bake_statistics().from_cache);
  EXPECT_GT(first->bake_statistics().rays, 0U);
  const auto again = render_home(home, options, pool_);
  EXPECT_TRUE(again->bake_statistics().from_cache);
  EXPECT_EQ(first->render(small_camera(), view, pool_).radiance,
            again->render(small_camera(), view, pool_).radiance);

  // Another home's light is not taken.
  home.lights[0].lumens = 1000;
  const auto other = render_home(home, options, pool_);
  EXPECT_FALSE(other->bake_statistics().from_cache);

  // Nor is a damaged file.
  auto bytes = read_file(options.light_cache);
  ASSERT_OK(bytes);
  (*bytes)[bytes->size() - 5] ^= 0x10U;
  ASSERT_OK(write_file(options.light_cache, *bytes));
  EXPECT_FALSE(render_home(home, options, pool_)->bake_statistics().from_cache);
  bytes->resize(100);
  ASSERT_OK(write_file(options.light_cache, *bytes));
  EXPECT_FALSE(render_home(home, options, pool_)->bake_statistics().from_cache);
}

TEST_F(RendererTest, RefusesWhatItCannotDraw) {
  HomeModel home = square_rooms(1);
  home.objects.push_back(box_object({2, 2, 0}));
  home.objects[0].model = "sofa";
  EXPECT_ERROR(Renderer::create(home, load_box, quick(), pool_, progress_), "sofa");
  RenderOptions options;
  options.samples_per_pixel = 0;
  EXPECT_ERROR(Renderer::create(home, load_box, options, pool_, progress_), "samples_per_pixel");
  options = {};
  options.bake_effort = 0;
  EXPECT_ERROR(Renderer::create(home, load_box, options, pool_, progress_), "bake_effort");
  const MeshLoader broken = [](const std::string&) -> Expected<TriangleMesh> {
    TriangleMesh mesh = box_mesh(Eigen::Vector3f::Ones(), {});
    mesh.triangles[0].corners[1] = 1000;
    return mesh;
  };
  EXPECT_ERROR(Renderer::create(home, broken, quick(), pool_, progress_), "corner 1000");
}

class Interrupted final : public Progress {
 public:
  void begin(std::string_view, std::optional<std::uint64_t>) override {}
  void advance(std::uint64_t, std::string_view) override {}
  void end() override {}
  [[nodiscard]] bool interrupted() const override { return true; }
};

TEST_F(RendererTest, BakeCanBeInterrupted) {
  Interrupted interrupted;
  EXPECT_ERROR(Renderer::create(square_rooms(1), load_box, quick(), pool_, interrupted),
               "interrupted");
}

}  // namespace
}  // namespace roomwise::simulation
