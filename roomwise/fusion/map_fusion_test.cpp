#include "roomwise/fusion/map_fusion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "roomwise/base/testing/testing.h"
#include "roomwise/fusion/frame_fusion.h"
#include "roomwise/fusion/surface_mesh.h"
#include "roomwise/fusion/testing/test_scenes.h"

namespace roomwise::fusion {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;
using testing::box;
using testing::distance_m;
using testing::half_space;
using testing::looking_at;
using testing::render;
using testing::Scene;
using testing::small_camera;

// A walk of eight frames past a box on a floor, before a wall.
class MapFusionTest : public ::testing::Test {
 protected:
  MapFusionTest() {
    const FrameSurfaceMaker maker(small_camera());
    for (FrameId i = 0; i < 8; ++i) {
      const double along = 0.15 * static_cast<double>(i);
      poses_[i] = looking_at({along, -1.5, 1.2}, {along + 0.2, 0.5, 0.3});
      const testing::Picture picture = render(scene_, poses_[i], small_camera(), 0.0014, i);
      frames_.push_back(maker.make(picture.color, picture.depth));
    }
  }

  void move_to(MapFusion& map, const FramePoses& poses, ThreadPool& pool) const {
    for (const Reintegration& step : map.reintegrations_for(poses)) {
      EXPECT_OK(map.apply(step, frames_[step.frame], pool));
    }
  }
  MapFusion fused_at(const FramePoses& poses, std::size_t threads = 2,
                     const MapFusionOptions& options = {}) const {
    ThreadPool pool(threads);
    MapFusion map(options);
    move_to(map, poses, pool);
    return map;
  }
  TriangleMesh mesh_of(TsdfVolume& field) {
    return extract_mesh(field, MeshOptions{}, pool_)->whole().value();
  }
  // The poses with random errors of some centimetres and degrees, for frames from `first` on.
  FramePoses wrong_poses(FrameId first = 0) const {
    RandomStream random(9);
    FramePoses wrong = poses_;
    for (auto& [frame, pose] : wrong) {
      geometry::Vector6d error;
      for (double& value : error) value = 0.05 * random.normal();
      if (frame >= first) pose = pose * RigidTransform::exp(error);
    }
    return wrong;
  }

  Scene scene_{half_space(Vector3d::UnitZ(), 0), half_space(-Vector3d::UnitY(), -1.5),
               box({0.2, 0.2, 0}, {0.6, 0.6, 0.5}, {20, 200, 90})};
  FramePoses poses_;
  std::vector<FrameSurface> frames_;
  ThreadPool pool_{2};
};

TEST_F(MapFusionTest, CorrectedPosesGiveTheFieldThatTheyWouldHaveGivenAtOnce) {
  MapFusion map = fused_at(wrong_poses());
  const MapFusion right = fused_at(poses_);
  EXPECT_FALSE(map.field() == right.field());
  move_to(map, poses_, pool_);
  EXPECT_TRUE(map.field() == right.field()) << "to the bit";
}

TEST_F(MapFusionTest, NoGhostIsLeftWhereAFrameWasWrong) {
  MapFusion map = fused_at(wrong_poses(5));
  const auto ghosts = [&](MapFusion& of) {
    std::size_t count = 0;
    for (const auto& vertex : mesh_of(of.field()).vertices) {
      count += std::abs(distance_m(scene_, vertex.cast<double>())) > 0.04 ? 1 : 0;
    }
    return count;
  };
  EXPECT_GT(ghosts(map), 0U);
  move_to(map, poses_, pool_);
  EXPECT_EQ(ghosts(map), 0U);
}

TEST_F(MapFusionTest, TheOrderOfFramesAndTheNumberOfThreadsMakeNoDifference) {
  const MapFusion forth = fused_at(poses_, 1);
  TsdfVolume back(TsdfOptions{});
  ThreadPool pool(3);
  for (auto pose = poses_.rbegin(); pose != poses_.rend(); ++pose) {
    ASSERT_OK(integrate_frame(back, frames_[pose->first], pose->second, pool));
  }
  EXPECT_TRUE(forth.field() == back);
}

TEST_F(MapFusionTest, WithoutColorsTheSurfaceIsTheSameInLessMemory) {
  MapFusionOptions options;
  options.field.keeps_colors = false;
  MapFusion bare = fused_at(poses_, 2, options), colored = fused_at(poses_);
  EXPECT_EQ(bare.field().block_count(), colored.field().block_count());
  EXPECT_LT(bare.field().memory_bytes(), 0.7 * static_cast<double>(colored.field().memory_bytes()));
  const TriangleMesh same = mesh_of(bare.field());
  const TriangleMesh mesh = mesh_of(colored.field());
  ASSERT_GT(mesh.vertices.size(), 1000U);
  EXPECT_EQ(same.vertices, mesh.vertices);
  EXPECT_EQ(same.normals, mesh.normals);
  EXPECT_EQ(same.triangles, mesh.triangles);
}

TEST_F(MapFusionTest, TakingEveryFrameOutLeavesNothing) {
  MapFusion map = fused_at(poses_);
  EXPECT_GT(map.field().memory_bytes(), 1'000'000U);
  move_to(map, {}, pool_);
  EXPECT_EQ(map.field().block_count(), 0U);
  EXPECT_TRUE(map.fused().empty());
}

TEST_F(MapFusionTest, FramesThatHardlyMovedStay) {
  const MapFusion map = fused_at(poses_);
  FramePoses moved = poses_;
  moved[1].translation.x() += 0.004;
  moved[2].translation.x() += 0.006;
  moved[3] =
      moved[3] * RigidTransform{Eigen::Quaterniond(Eigen::AngleAxisd(0.003, Vector3d::UnitX())),
                                Vector3d::Zero()};
  moved.erase(7);
  const auto steps = map.reintegrations_for(moved);
  ASSERT_EQ(steps.size(), 3U);
  EXPECT_EQ(steps[0].frame, 7U);
  EXPECT_FALSE(steps[0].in.has_value());
  EXPECT_EQ(steps[1].frame, 2U);
  EXPECT_EQ(steps[2].frame, 3U);
  EXPECT_TRUE(steps[2].out && steps[2].in);
}

TEST_F(MapFusionTest, WhatIsGoneIsOutvoted) {
  // The box stood there in two frames, and then six see through where it was.
  Scene emptied = scene_;
  emptied.pop_back();
  const FrameSurfaceMaker maker(small_camera());
  TsdfVolume field(TsdfOptions{});
  for (const auto& [frame, pose] : poses_) {
    const testing::Picture picture = render(frame < 2 ? scene_ : emptied, pose, small_camera());
    ASSERT_OK(integrate_frame(field, maker.make(picture.color, picture.depth), pose, pool_));
  }
  for (const auto& vertex : mesh_of(field).vertices) {
    EXPECT_LT(std::abs(distance_m(emptied, vertex.cast<double>())), 0.03) << vertex.transpose();
  }
}

TEST_F(MapFusionTest, APoseThatIsNotFiniteIsRefused) {
  MapFusion map = fused_at(poses_);
  RigidTransform lost = poses_.at(0);
  lost.translation.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_ERROR(map.apply({0, poses_.at(0), lost}, frames_[0], pool_), "not finite");
  EXPECT_TRUE(map.field() == fused_at(poses_).field());
}

TEST(MapFusionOptions, SayWhatIsWrong) {
  EXPECT_OK(MapFusionOptions{}.validate());
  MapFusionOptions wrong;
  wrong.max_shift_m = -1;
  EXPECT_ERROR(wrong.validate(), "max_shift_m");
  wrong = {.field = {.voxel_size_m = 0}};
  EXPECT_ERROR(wrong.validate(), "voxel_size_m");
  wrong = {.field = {.truncation_voxels = 1}};
  EXPECT_ERROR(wrong.validate(), "truncation_voxels");
}

}  // namespace
}  // namespace roomwise::fusion
