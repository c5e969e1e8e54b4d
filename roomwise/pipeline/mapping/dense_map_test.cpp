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

// Half of the room's pictures are taken away, and what their depth showed is left with those
// before.
TEST_F(DenseMapTest, DepthBetweenPicturesShowsWhatNoPictureDoes) {
  auto all = keyframes();
  auto half = home::Home::create(folder_ / "half.home");
  ASSERT_OK(half);
  const geometry::PinholeCamera camera = fusion::testing::small_camera();
  home::MapCommit step;
  step.recording = half->add_recording({"room", "", camera, kKeyframes}).value();
  step.next_frame_index = kKeyframes;
  for (std::size_t i = 0; i < kKeyframes; i += 2) {
    auto& added =
        step.keyframes.emplace_back(home::NewKeyframe{{i / 2, i, static_cast<TimestampNs>(i + 1)},
                                                      all[i].pose,
                                                      home_->images(i).value(),
                                                      {},
                                                      {}});
    const RigidTransform from_view =
        all[i].pose.world_from_keyframe.inverse() * all[i + 1].pose.world_from_keyframe;
    added.depth_views = {{static_cast<TimestampNs>(i + 2), from_view, home_->images(i + 1)->depth}};
    all[i + 1].pose.world_from_keyframe = all[i].pose.world_from_keyframe * from_view;
  }
  ASSERT_OK(half->commit(step));
  const auto with = build_dense_map(*half, map_keyframes(*half).value(), {}, run_);
  ASSERT_OK(with);
  fusion::TsdfOptions no_colors;
  no_colors.keeps_colors = false;
  EXPECT_TRUE(build_dense_map(*half, map_keyframes(*half).value(), no_colors, run_)->field() ==
              build_dense_map(*home_, all, no_colors, run_)->field())
      << "the same surfaces as of all pictures";
  EXPECT_FALSE(with->field() == build_dense_map(*home_, all, {}, run_)->field())
      << "which have no colour where no picture shows them";

  auto corrected = map_keyframes(*half).value();
  corrected[3].pose.world_from_keyframe.translation.x() += 0.1;
  auto map = build_dense_map(*half, corrected, {}, run_);
  ASSERT_OK(map);
  ASSERT_OK(map->follow(*half, map_keyframes(*half).value(), run_));
  EXPECT_TRUE(map->field() == with->field()) << "they follow their key-frames";
  corrected.pop_back();
  ASSERT_OK(map->follow(*half, corrected, run_));
  EXPECT_EQ(map->fused().size(), kKeyframes - 2) << "and go with them";

  ASSERT_OK(
      half->database().run("UPDATE keyframe_depth_views SET depth = x'00' "
                           "WHERE keyframe_id = 2"));
  EXPECT_ERROR(build_dense_map(*half, map_keyframes(*half).value(), {}, run_), "key-frame 2");
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
