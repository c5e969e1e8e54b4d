#include "roomwise/pipeline/mapping/dense_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "roomwise/base/testing/testing.h"
#include "roomwise/fusion/testing/test_scenes.h"
#include "roomwise/image/codec.h"
#include "roomwise/pipeline/mapping/gravity_aligned_map.h"
#include "roomwise/pipeline/stored/keyframe_images.h"
#include "roomwise/pipeline/testing/mapped_room.h"

namespace roomwise::pipeline {
namespace {

using Eigen::Vector3d;
using fusion::testing::looking_at;
using geometry::RigidTransform;

class DenseMapTest : public testing::MappedRoom {};

TEST_F(DenseMapTest, FollowsWhenTheMapIsCorrected) {
  auto bent = keyframes();
  for (std::size_t i = 0; i < bent.size(); i += 3) {
    bent[i].pose.world_from_keyframe.translation += Vector3d(0.04, 0, 0.03);
  }
  bent.pop_back();
  auto map = build_dense_map(*home_, bent, {}, run_);
  ASSERT_OK(map);
  const auto right = build_dense_map(*home_, keyframes(), {}, run_);
  ASSERT_OK(right);
  EXPECT_FALSE(map->field() == right->field());
  ASSERT_OK(map->follow(*home_, keyframes(), run_));
  EXPECT_TRUE(map->field() == right->field());
  EXPECT_EQ(map->fused().size(), kKeyframes);
}

TEST_F(DenseMapTest, RefusesVoxelsOfNoUse) {
  EXPECT_ERROR(build_dense_map(*home_, keyframes(), {.voxel_size_m = 0}, run_), "voxel_size_m");
}

TEST_F(DenseMapTest, NamesTheKeyframeThatIsDamaged) {
  ASSERT_OK(
      home_->database().run("UPDATE keyframe_images SET depth = x'00' WHERE keyframe_id = 3"));
  EXPECT_ERROR(build_dense_map(*home_, keyframes(), {}, run_), "a.home: key-frame 3");
}

TEST_F(DenseMapTest, NamesTheKeyframeWhoseImageHasAnotherSize) {
  ASSERT_OK(home_->database().run("UPDATE recordings SET width_px = width_px + 1"));
  EXPECT_ERROR(build_dense_map(*home_, keyframes(), {}, run_), "its camera takes");
}

TEST_F(DenseMapTest, AHomeWithoutAMapIsRefused) {
  const auto empty = home::Home::create(folder_ / "empty.home");
  ASSERT_OK(empty);
  EXPECT_ERROR(build_gravity_aligned_map(*empty, {}, run_), "empty.home: the home has no map yet");
}

TEST_F(DenseMapTest, CellsMustGoWithTheVoxels) {
  EXPECT_OK(validate_cell(0.05, 0.02));
  EXPECT_ERROR(validate_cell(0.01, 0.02), "0.04 to 0.16");
  EXPECT_ERROR(validate_cell(0.2, 0.02), "0.04 to 0.16");
  EXPECT_ERROR(validate_cell(std::nan(""), 0.02), "0.04 to 0.16");
}

}  // namespace
}  // namespace roomwise::pipeline
