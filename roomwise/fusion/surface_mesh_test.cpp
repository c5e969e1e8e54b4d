#include "roomwise/fusion/surface_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "roomwise/base/testing/testing.h"
#include "roomwise/fusion/testing/test_scenes.h"

namespace roomwise::fusion {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using testing::all_round;
using testing::box;
using testing::distance_m;
using testing::euler_characteristic;
using testing::fuse;
using testing::half_space;
using testing::is_closed;
using testing::looking_at;
using testing::Scene;
using testing::sphere;
using testing::true_field;

constexpr MeshOptions kAll{.min_weight = 1, .min_component_m2 = 0};

class SurfaceMeshTest : public ::testing::Test {
 protected:
  static double max_error_m(const TriangleMesh& mesh, const Scene& scene) {
    double max_m = 0;
    for (const Vector3f& vertex : mesh.vertices) {
      max_m = std::max(max_m, std::abs(distance_m(scene, vertex.cast<double>())));
    }
    return max_m;
  }
  TriangleMesh mesh_of(TsdfVolume& field, const MeshOptions& options = {}) {
    return extract_mesh(field, options, pool_)->whole().value();
  }
  TriangleMesh mesh_of(TsdfVolume&& field, const MeshOptions& options = {}) {
    return mesh_of(field, options);
  }
  ThreadPool pool_{2};
};

TEST_F(SurfaceMeshTest, ASphereIsClosedAndItsNormalsPointOut) {
  const Vector3d center(0.011, -0.007, 0.003);
  const Scene scene{sphere(center, 0.2)};
  const TriangleMesh mesh = mesh_of(true_field(scene, -2, 2), kAll);
  ASSERT_GT(mesh.vertices.size(), 500U);
  ASSERT_EQ(mesh.normals.size(), mesh.vertices.size());
  ASSERT_EQ(mesh.colors.size(), mesh.vertices.size());
  EXPECT_TRUE(is_closed(mesh));
  EXPECT_EQ(euler_characteristic(mesh), 2);
  EXPECT_LT(max_error_m(mesh, scene), 0.001);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vector3d out = (mesh.vertices[i].cast<double>() - center).normalized();
    EXPECT_GT(out.dot(mesh.normals[i].cast<double>()), 0.99);
  }
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vector3d corner = mesh.vertices[a].cast<double>();
    const Vector3d across =
        (mesh.vertices[b].cast<double>() - corner).cross(mesh.vertices[c].cast<double>() - corner);
    EXPECT_GE(across.dot(corner - center), 0) << "triangles go round anticlockwise from outside";
  }
}

TEST_F(SurfaceMeshTest, ABoxHasItsCornersWithinAVoxel) {
  const Scene scene{box({-0.15, -0.11, -0.07}, {0.13, 0.12, 0.09})};
  const TriangleMesh mesh = mesh_of(true_field(scene, -2, 2), kAll);
  EXPECT_TRUE(is_closed(mesh));
  EXPECT_EQ(euler_characteristic(mesh), 2);
  EXPECT_LT(max_error_m(mesh, scene), 0.01);
}

TEST_F(SurfaceMeshTest, AFusedSphereIsClosedWhenItIsSeenFromAllSides) {
  const Scene scene{sphere({0.02, 0.01, 0}, 0.3, {100, 150, 200})};
  const TriangleMesh mesh = mesh_of(fuse(scene, all_round({0, 0, 0}, 1.2), pool_));
  EXPECT_TRUE(is_closed(mesh));
  EXPECT_EQ(euler_characteristic(mesh), 2);
  EXPECT_LT(max_error_m(mesh, scene), 0.2 * TsdfOptions{}.voxel_size_m);
  for (const Rgb8 color : mesh.colors) EXPECT_EQ(color, (Rgb8{100, 150, 200}));
}

TEST_F(SurfaceMeshTest, AFusedPlaneIsFlatUnderTheNoiseOfACamera) {
  const Scene scene{half_space(Vector3d::UnitZ(), 0.013)};
  std::vector<testing::RigidTransform> cameras;
  for (int i = 0; i < 10; ++i) {
    cameras.push_back(looking_at({0.1 * i, 0, 1.5}, {0.1 * i + 0.6, 0.2, 0}));
  }
  const TriangleMesh mesh = mesh_of(fuse(scene, cameras, pool_, {}, 0.0014));
  ASSERT_GT(mesh.vertices.size(), 3000U);
  std::size_t near = 0;
  for (const Vector3f& vertex : mesh.vertices) {
    near += std::abs(distance_m(scene, vertex.cast<double>())) < 0.004 ? 1 : 0;
  }
  EXPECT_GT(static_cast<double>(near), 0.99 * static_cast<double>(mesh.vertices.size()));
  EXPECT_LT(max_error_m(mesh, scene), 0.02);
}

TEST_F(SurfaceMeshTest, AFusedCornerOfARoomStaysACorner) {
  const Scene scene{half_space(Vector3d::UnitX(), 0), half_space(Vector3d::UnitY(), 0),
                    half_space(Vector3d::UnitZ(), 0)};
  std::vector<testing::RigidTransform> cameras;
  for (const double side : {0.8, 1.2, 1.6}) {
    cameras.push_back(looking_at({side, 2.2 - side, 1.3}, {0, 0, 0.2}));
    cameras.push_back(looking_at({side, 2.2 - side, 0.9}, {0.2, 0.2, 0}));
  }
  const TriangleMesh mesh = mesh_of(fuse(scene, cameras, pool_));
  double sum_m = 0;
  for (const Vector3f& vertex : mesh.vertices) {
    sum_m += std::abs(distance_m(scene, vertex.cast<double>()));
  }
  EXPECT_LT(sum_m / static_cast<double>(mesh.vertices.size()), 0.001);
  EXPECT_LT(max_error_m(mesh, scene), 0.015) << "three quarters of a voxel, in the corner itself";
}

// Two boxes, one before the other: nothing may hang in the air between their outlines.
TEST_F(SurfaceMeshTest, OutlinesDoNotSmear) {
  const Scene scene{box({-0.2, -0.2, 0.8}, {0.2, 0.2, 1.0}), half_space(-Vector3d::UnitZ(), -2.0)};
  std::vector<testing::RigidTransform> cameras;
  for (int i = 0; i < 6; ++i) {
    cameras.push_back(
        looking_at({0.1 * i - 0.25, 0.05 * i, -0.3}, {0, 0, 1.0}, -Vector3d::UnitY()));
  }
  const TriangleMesh mesh = mesh_of(fuse(scene, cameras, pool_));
  EXPECT_LT(max_error_m(mesh, scene), 0.03);
}

TEST_F(SurfaceMeshTest, SmallComponentsGo) {
  const Scene scene{sphere({-0.1, 0, 0}, 0.12), sphere({0.2, 0, 0}, 0.04)};
  TsdfVolume field = true_field(scene, -2, 2);
  const TriangleMesh all = mesh_of(field, kAll);
  const TriangleMesh large = mesh_of(field, {.min_weight = 1, .min_component_m2 = 0.05});
  EXPECT_EQ(euler_characteristic(all), 4);
  EXPECT_EQ(euler_characteristic(large), 2);
  EXPECT_TRUE(is_closed(large));
  EXPECT_TRUE(std::ranges::all_of(large.vertices, [](const Vector3f& v) { return v.x() < 0.1F; }));
  EXPECT_TRUE(mesh_of(field, {.min_weight = 1, .min_component_m2 = 1}).vertices.empty());
}

TEST_F(SurfaceMeshTest, WhatWasHardlySeenDoesNotCount) {
  const Scene scene{sphere({0, 0, 0}, 0.2)};
  TsdfVolume field = true_field(scene, -2, 2);
  EXPECT_TRUE(mesh_of(field, {.min_weight = 101}).triangles.empty());
  EXPECT_FALSE(mesh_of(field, {.min_weight = 100}).triangles.empty());
}

TEST(MeshOptions, SayWhatIsWrong) {
  EXPECT_OK(MeshOptions{}.validate());
  EXPECT_ERROR(MeshOptions{.min_weight = 0}.validate(), "min_weight");
  EXPECT_ERROR(MeshOptions{.min_component_m2 = -1}.validate(), "min_component_m2");
}

}  // namespace
}  // namespace roomwise::fusion
