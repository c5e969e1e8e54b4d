#include "roomwise/fusion/tsdf_volume.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::fusion {
namespace {

using Eigen::Vector3i;

// Whatever sums can be, colours in every second block.
std::unique_ptr<VoxelBlock> any_block(std::uint64_t seed) {
  RandomStream random(seed);
  const auto any = [&] {
    return static_cast<std::uint32_t>(random.index(std::uint64_t{1} << 32U));
  };
  auto block = std::make_unique<VoxelBlock>();
  for (Voxel& voxel : block->voxels) {
    voxel.weight = static_cast<std::uint32_t>(random.index(2'000'000));
    voxel.distance_sum =
        static_cast<std::int32_t>(kStepsPerTruncation * voxel.weight);  // in the open
    if (random.index(3) == 0) voxel.distance_sum = static_cast<std::int32_t>(any());
    if (random.index(3) == 0) voxel = {};
  }
  if (seed % 2 == 0) return block;
  block->colors = std::make_unique<std::array<ColorSum, kBlockVoxels>>();
  for (ColorSum& color : *block->colors) color = {any(), any(), any(), any()};
  return block;
}

class TsdfVolumeTest : public ::testing::Test {
 protected:
  // Rows of blocks to both sides of the origin.
  TsdfVolumeTest() {
    for (int z = -2; z < 3; ++z) {
      for (int x = -20; x < 20; ++x) places_.emplace_back(x, x % 3 - 1, z);
    }
  }
  // One block after the other.
  void fill(TsdfVolume& field) const {
    for (std::size_t i = 0; i < places_.size(); ++i) {
      ASSERT_OK(field.bring_to_change(std::span(places_).subspan(i, 1)));
      field.insert(places_[i], any_block(i));
    }
  }
  roomwise::testing::ScratchFolder folder_;
  std::vector<Vector3i> places_;
};

TEST_F(TsdfVolumeTest, GivesBackToTheBitWhatDoesNotFit) {
  TsdfVolume whole({}), bounded({}, {1, folder_.path()});
  fill(whole);
  fill(bounded);
  EXPECT_LT(bounded.memory_bytes(), whole.memory_bytes() / 4);
  EXPECT_EQ(bounded.block_count(), places_.size());
  EXPECT_EQ(bounded.blocks(), whole.blocks());
  EXPECT_TRUE(bounded == whole);
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path())) << "the scratch file has no name";
  // Each is changed and pushed out again.
  for (TsdfVolume* field : {&whole, &bounded}) {
    for (std::size_t i = 0; i < places_.size(); ++i) {
      ASSERT_OK(field->bring_to_change(std::span(places_).subspan(i, 1)));
      ASSERT_NE(field->find(places_[i]), nullptr);
      field->find(places_[i])->voxels[i % kBlockVoxels] = {-7, 2'000'000'000};
    }
  }
  EXPECT_TRUE(bounded == whole);
  ASSERT_OK(bounded.bring_to_change(std::span(places_).first(1)));
  bounded.find(places_[0])->voxels[5].weight += 1;
  EXPECT_FALSE(bounded == whole);
}

TEST_F(TsdfVolumeTest, WhatIsAskedForAtOnceIsInMemory) {
  TsdfVolume field({}, {1, folder_.path()});
  fill(field);
  const std::vector<Vector3i> middle{{0, -1, 0}};
  ASSERT_OK(field.bring_around(middle));
  for (const Vector3i& place : places_) {
    if ((place - middle[0]).cwiseAbs().maxCoeff() > 1) continue;
    EXPECT_NE(field.find(place), nullptr);
  }
  EXPECT_EQ(field.find({-20, places_[0].y(), 2}), nullptr) << "far away";
  ASSERT_OK(field.bring(places_));
  for (const Vector3i& place : places_) EXPECT_NE(field.find(place), nullptr);
}

TEST_F(TsdfVolumeTest, WhatIsErasedStaysSo) {
  TsdfVolume field({}, {1, folder_.path()});
  fill(field);
  for (const Vector3i& place : places_) {
    ASSERT_OK(field.bring_to_change(std::array{place}));
    field.erase(place);
  }
  EXPECT_EQ(field.block_count(), 0U);
  EXPECT_TRUE(field == TsdfVolume({}));
}

TEST_F(TsdfVolumeTest, NamesAFolderThatIsNotThere) {
  TsdfVolume field({}, {1, folder_ / "nowhere"});
  field.insert({0, 0, 0}, any_block(0));
  ASSERT_OK(field.bring_to_change(std::array{Vector3i(0, 0, 0)}));
  EXPECT_ERROR(field.bring_to_change(std::array{Vector3i(100, 0, 0)}),
               "nowhere: no scratch file can be made there");
  EXPECT_NE(field.find({0, 0, 0}), nullptr) << "nothing is lost";
}

}  // namespace
}  // namespace roomwise::fusion
