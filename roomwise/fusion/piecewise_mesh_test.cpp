#include "roomwise/fusion/piecewise_mesh.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>

#include "roomwise/base/testing/testing.h"
#include "roomwise/fusion/floor_grid.h"
#include "roomwise/fusion/gravity_aligned_frame.h"
#include "roomwise/fusion/occupancy.h"
#include "roomwise/fusion/surface_mesh.h"
#include "roomwise/fusion/testing/test_scenes.h"

namespace roomwise::fusion {
namespace {

using testing::box;
using testing::half_space;
using testing::looking_at;
using testing::RigidTransform;
using testing::Scene;
using testing::Vector3d;

// A walk of 6 m along a wall, past boxes and past things too small to be kept.
class BoundedFusionTest : public ::testing::Test {
 protected:
  BoundedFusionTest() {
    scene_ = {half_space(Vector3d::UnitZ(), 0), half_space(-Vector3d::UnitY(), -1.5)};
    for (int i = 0; i < 6; ++i) {
      scene_.push_back(box({1.0 * i, 0.2, 0}, {1.0 * i + 0.4, 0.6, 0.5}, {20, 200, 90}));
      scene_.push_back(box({1.0 * i + 0.5, 0.3, 0.6}, {1.0 * i + 0.53, 0.33, 0.64}));
    }
    for (int i = 0; i < 13; ++i)
      cameras_.push_back(looking_at({0.5 * i, -1.3, 1.2}, {0.5 * i + 0.2, 0.5, 0.3}));
  }
  [[nodiscard]] Expected<TsdfVolume> fuse(const WorkingSet& working_set) {
    TsdfVolume field({}, working_set);
    const FrameSurfaceMaker maker(testing::small_camera());
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      const auto picture = testing::render(scene_, cameras_[i], testing::small_camera(), 0.0014, i);
      ROOMWISE_RETURN_IF_ERROR(
          integrate_frame(field, maker.make(picture.color, picture.depth), cameras_[i], pool_));
    }
    return field;
  }
  static Expected<FloorGrid> grid_of(TsdfVolume& field, const PiecewiseMesh& mesh,
                                     ThreadPool& pool) {
    return make_floor_grid(mesh, {}, [&](const auto& visit) {
      return visit_free_cells(field, {}, 0.05, pool, visit);
    });
  }
  static void expect_same(const TriangleMesh& a, const TriangleMesh& b) {
    EXPECT_EQ(a.vertices, b.vertices);
    EXPECT_EQ(a.normals, b.normals);
    EXPECT_EQ(a.colors, b.colors);
    EXPECT_EQ(a.triangles, b.triangles);
  }

  roomwise::testing::ScratchFolder folder_;
  Scene scene_;
  std::vector<RigidTransform> cameras_;
  ThreadPool pool_{2};
};

TEST_F(BoundedFusionTest, FieldSurfaceAndFloorAreTheSameToTheBitInHardlyAnyMemory) {
  auto whole = fuse({}), bounded = fuse({1, folder_.path()});
  ASSERT_OK(whole);
  ASSERT_OK(bounded);
  EXPECT_LT(bounded->memory_bytes(), whole->memory_bytes() * 2 / 3);
  EXPECT_TRUE(*bounded == *whole);

  ThreadPool one(1);  // whose pieces are smaller
  const auto mesh = extract_mesh(*whole, MeshOptions{}, pool_);
  const auto pieces = extract_mesh(*bounded, MeshOptions{}, one);
  ASSERT_OK(mesh);
  ASSERT_OK(pieces);
  ASSERT_GT(mesh->vertex_count(), 10'000U);
  expect_same(pieces->whole().value(), mesh->whole().value());
  EXPECT_EQ(pieces->vertex_count(), mesh->whole()->vertices.size());
  EXPECT_EQ(pieces->triangle_count(), mesh->whole()->triangles.size());
  const auto all = extract_mesh(*bounded, {.min_component_m2 = 0}, one);
  ASSERT_OK(all);
  EXPECT_GT(all->vertex_count(), pieces->vertex_count()) << "small things went";
  expect_same(all->whole().value(),
              extract_mesh(*whole, {.min_component_m2 = 0}, pool_)->whole().value());

  const auto frame = find_gravity_aligned_frame(*mesh, cameras_);
  const auto frame_of_pieces = find_gravity_aligned_frame(*pieces, cameras_);
  ASSERT_OK(frame);
  ASSERT_OK(frame_of_pieces);
  ASSERT_TRUE(frame->has_floor);
  EXPECT_EQ(frame_of_pieces->gravity_from_world.translation, frame->gravity_from_world.translation);
  EXPECT_EQ(frame_of_pieces->gravity_from_world.rotation.coeffs(),
            frame->gravity_from_world.rotation.coeffs());

  const auto grid = grid_of(*whole, *mesh, pool_), same = grid_of(*bounded, *pieces, one);
  ASSERT_OK(grid);
  ASSERT_OK(same);
  ASSERT_EQ(same->columns(), grid->columns());
  ASSERT_EQ(same->rows(), grid->rows());
  EXPECT_EQ(same->origin_m(), grid->origin_m());
  for (int row = 0; row < grid->rows(); ++row) {
    for (int column = 0; column < grid->columns(); ++column)
      ASSERT_EQ(same->at(column, row), grid->at(column, row));
  }
  const auto cells = occupancy_cells(*whole, *mesh, {}, 0.05, pool_);
  const auto same_cells = occupancy_cells(*bounded, *pieces, {}, 0.05, one);
  ASSERT_OK(cells);
  ASSERT_OK(same_cells);
  ASSERT_EQ(same_cells->size(), cells->size());
  for (std::size_t i = 0; i < cells->size(); ++i) {
    EXPECT_EQ((*same_cells)[i].cell, (*cells)[i].cell);
    EXPECT_EQ((*same_cells)[i].is_occupied, (*cells)[i].is_occupied);
  }
}

TEST_F(BoundedFusionTest, ThePiecesInAnotherFrameAreThoseOfTheWhole) {
  auto field = fuse({});
  ASSERT_OK(field);
  const auto mesh = extract_mesh(*field, MeshOptions{}, pool_);
  ASSERT_OK(mesh);
  const RigidTransform moved{
      Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Vector3d(1, 2, 3).normalized())), {4, 5, 6}};
  std::size_t pieces = 0;
  ASSERT_OK(mesh->for_each([&](const MeshPiece&) { ++pieces; }));
  EXPECT_GT(pieces, 3U);
  expect_same(transformed(moved, *mesh).whole().value(),
              transformed(moved, mesh->whole().value()).whole().value());
}

// A file may not grow beyond a limit here, as on a disk that is full.
TEST_F(BoundedFusionTest, AFullDiskIsNamedAndTheFieldStays) {
  auto whole = fuse({});
  ASSERT_OK(whole);
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit full{20'000, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &full), 0);
  const auto bounded = fuse({1, folder_.path()});
  const auto pieces = extract_mesh(*whole, MeshOptions{}, pool_);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  EXPECT_ERROR(bounded, folder_.path().string() + ": the scratch file there cannot be written");
  EXPECT_OK(pieces) << "what fits into memory needs no disk";
}

}  // namespace
}  // namespace roomwise::fusion
