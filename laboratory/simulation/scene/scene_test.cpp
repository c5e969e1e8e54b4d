#include "laboratory/simulation/scene/scene.h"

#include <gmock/gmock.h>

#include <cmath>

#include "laboratory/simulation/furniture/tessellation.h"
#include "laboratory/simulation/testing/test_homes.h"
#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::simulation {
namespace {

TEST(Tessellation, SplitsLongEdgesAndKeepsTheSurface) {
  const TriangleMesh box = box_mesh({1.0F, 0.4F, 0.7F}, {});
  const TriangleMesh fine = tessellate(box, 0.1F, 0.05F);
  EXPECT_NEAR(area_of(fine), area_of(box), 1e-4);
  for (const TriangleMesh::Triangle& triangle : fine.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = triangle.corners[i], b = triangle.corners[(i + 1) % 3];
      const bool is_top = fine.normals[a].z() > 0.9F;
      EXPECT_LE((fine.positions[a] - fine.positions[b]).norm(), is_top ? 0.0501F : 0.1001F);
    }
  }
}

TEST(Tessellation, LeavesFineMeshesAlone) {
  const TriangleMesh box = box_mesh({0.05F, 0.05F, 0.05F}, {});
  EXPECT_EQ(tessellate(box, 0.1F, 0.1F).triangles.size(), box.triangles.size());
}

TEST(Scene, RaysTracedTogetherMeetWhatSingleRaysMeet) {
  const auto scene = Scene::build(square_rooms(2), {});
  ASSERT_OK(scene);
  RandomStream random(6);
  const Eigen::Vector3f origin(2, 2, 1.3F);
  for (int i = 0; i < 500; ++i) {
    RayCaster::Bundle bundle;
    const std::size_t count = 1 + random.index(RayCaster::kBundle);
    const double turn = 6.3 * random.uniform();
    while (bundle.count < count) {
      const double angle = turn + 0.1 * random.uniform();
      const Eigen::Vector3d direction(std::cos(angle), std::sin(angle), random.uniform() - 0.5);
      bundle.add(direction.cast<float>(), i % 2 == 0 ? 100.0F : 2.2F);
    }
    const auto hits = scene->rays().first_hits(origin, bundle);
    for (std::size_t ray = 0; ray < hits.size(); ++ray) {
      const auto single =
          ray < count ? scene->rays().first_hit(origin, bundle.directions[ray], 0,
                                                bundle.farthest[ray], RayCaster::Meets::kEverything)
                      : std::nullopt;
      ASSERT_EQ(hits[ray].has_value(), single.has_value());
      if (!single) continue;
      EXPECT_NEAR(hits[ray]->distance, single->distance, 1e-5F);
    }
  }
}

TEST(Scene, RaysFindNoCrackInAClosedRoom) {
  HomeModel home = square_rooms(2);
  home.doors[0].has_leaf = true;
  home.doors[0].open_rad = 0.9;
  const auto scene = Scene::build(home, {});
  ASSERT_OK(scene);
  RandomStream random(5);
  for (int i = 0; i < 50'000; ++i) {
    const Eigen::Vector3f origin(static_cast<float>(0.5 + 3 * random.uniform()),
                                 static_cast<float>(0.5 + 3 * random.uniform()), 1.3F);
    // Towards the edges, where surfaces meet.
    Eigen::Vector3f target(random.uniform() < 0.5 ? 0.0F : 4.0F,
                           random.uniform() < 0.5 ? 0.0F : 4.0F,
                           random.uniform() < 0.5 ? 0.0F : 2.6F);
    target[static_cast<int>(random.index(3))] = static_cast<float>(2.6 * random.uniform());
    EXPECT_TRUE(
        scene->rays().first_hit(origin, target - origin, 0, 100, RayCaster::Meets::kEverything));
  }
}

TEST(Scene, TwoBuildsGiveTheSameHits) {
  HomeModel home = square_rooms(2);
  home.objects.push_back(box_object({2, 2, 0}));
  const std::vector<std::shared_ptr<const TriangleMesh>> meshes{
      std::make_shared<const TriangleMesh>(box_mesh({0.6F, 0.5F, 0.8F}, {}))};
  const auto a = Scene::build(home, meshes), b = Scene::build(home, meshes);
  ASSERT_OK(a);
  ASSERT_OK(b);
  RandomStream random(6);
  for (int i = 0; i < 20'000; ++i) {
    const Eigen::Vector3f direction(static_cast<float>(random.normal()),
                                    static_cast<float>(random.normal()),
                                    static_cast<float>(random.normal()));
    const Eigen::Vector3f origin(0.7F, 1.1F, 1.3F);
    const auto p = a->rays().first_hit(origin, direction, 0, 100, RayCaster::Meets::kOpaque);
    const auto q = b->rays().first_hit(origin, direction, 0, 100, RayCaster::Meets::kOpaque);
    ASSERT_EQ(p.has_value(), q.has_value());
    if (!p) continue;
    EXPECT_EQ(p->triangle, q->triangle);
    EXPECT_EQ(p->distance, q->distance);
  }
}

TEST(Scene, GlassIsSeenButDoesNotBlockLight) {
  HomeModel home = square_rooms(1);
  home.objects.push_back(box_object({2, 2, 0}));
  SurfaceMaterial glass;
  glass.opacity = 0.2F;
  const std::vector<std::shared_ptr<const TriangleMesh>> meshes{
      std::make_shared<const TriangleMesh>(box_mesh({0.6F, 0.5F, 0.8F}, glass))};
  const auto scene = Scene::build(home, meshes);
  ASSERT_OK(scene);
  const Eigen::Vector3f origin(0.5F, 2, 0.4F), forward = Eigen::Vector3f::UnitX();
  EXPECT_TRUE(scene->rays().has_clear_triangles());
  EXPECT_NEAR(
      scene->rays().first_hit(origin, forward, 0, 100, RayCaster::Meets::kEverything)->distance,
      1.2, 1e-4);
  EXPECT_NEAR(scene->rays().first_hit(origin, forward, 0, 100, RayCaster::Meets::kOpaque)->distance,
              3.5, 0.02);
  EXPECT_FALSE(scene->rays().is_blocked(origin, forward, 0, 3));
}

TEST(Scene, WindowIsAHoleInTheWall) {
  HomeModel home = square_rooms(1);
  Window window;
  window.opening = {{4.06, 2}, false, 1.2, 0.9, 2.1};
  home.windows.push_back(window);
  const auto scene = Scene::build(home, {});
  ASSERT_OK(scene);
  const Eigen::Vector3f origin(1, 1.75F, 1.5F), forward = Eigen::Vector3f::UnitX();
  EXPECT_FALSE(scene->rays().first_hit(origin, forward, 0, 100, RayCaster::Meets::kOpaque));
  EXPECT_TRUE(scene->outside().seen_through_a_window(origin, forward));
  EXPECT_FALSE(scene->outside().seen_through_a_window(origin, -forward));
  EXPECT_TRUE(scene->rays().is_blocked({1, 0.5F, 1.5F}, forward, 0, 100));
}

}  // namespace
}  // namespace roomwise::simulation
