#include "roomwise/mapping/frontend/measurement_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/motion/measurement_bytes.h"

namespace roomwise::mapping {
namespace {

// Measurements that say which they are.
motion::FrameMeasurements measurements_of(KeyframeId id) {
  constexpr Eigen::Index kFeatures = 20;
  motion::MeasuredFeatures measured;
  measured.features.descriptors = features::FloatDescriptors(
      features::FloatDescriptors::Constant(kFeatures, 64, static_cast<float>(id)));
  measured.features.keypoints.resize(kFeatures);
  measured.pixels.assign(kFeatures, Eigen::Vector2d::Constant(static_cast<double>(id)));
  measured.points.assign(kFeatures, Eigen::Vector3d::Constant(static_cast<double>(id)));
  return measured;
}

class MeasurementStoreTest : public ::testing::Test {
 protected:
  static void fill(MeasurementStore& store, KeyframeId count) {
    for (KeyframeId id = 0; id < count; ++id) ASSERT_OK(store.add(measurements_of(id)));
  }
  static void expect_all_there(MeasurementStore& store) {
    for (KeyframeId id = 0; id < store.size(); ++id) {
      const auto measurements = store.get(id);
      ASSERT_OK(measurements);
      EXPECT_EQ(motion::to_bytes(**measurements), motion::to_bytes(measurements_of(id)));
    }
  }
  static std::size_t files_in(const std::filesystem::path& folder) {
    const std::filesystem::directory_iterator files(folder);
    return static_cast<std::size_t>(std::distance(begin(files), end(files)));
  }
  roomwise::testing::ScratchFolder folder_;
  const std::size_t one_ = motion::memory_bytes(measurements_of(0));
};

TEST_F(MeasurementStoreTest, GivesBackToTheBitWhatDoesNotFit) {
  MeasurementStore store({3 * one_, folder_.path()});
  fill(store, 10);
  EXPECT_LE(store.bytes_in_memory(), 3 * one_);
  expect_all_there(store);
  expect_all_there(store);  // and again, after each was pushed out and back
  EXPECT_LE(store.bytes_in_memory(), 3 * one_);
  EXPECT_EQ(files_in(folder_.path()), 0U) << "the scratch file has no name";
}

TEST_F(MeasurementStoreTest, PushesOutWhatWasNotUsedForLongest) {
  MeasurementStore store({3 * one_, folder_.path()});
  fill(store, 3);
  const auto first = store.get(0);
  ASSERT_OK(first);
  ASSERT_OK(store.add(measurements_of(3)));
  const auto again = store.get(0);
  ASSERT_OK(again);
  EXPECT_EQ(*again, *first) << "still the same in memory";
}

TEST_F(MeasurementStoreTest, WhatIsInUseStaysGood) {
  MeasurementStore store({0, folder_.path()});
  fill(store, 2);
  const auto held = store.get(0);
  ASSERT_OK(held);
  ASSERT_OK(store.get(1));
  EXPECT_EQ((*held)->features().points[0].x(), 0);
  EXPECT_LE(store.bytes_in_memory(), one_) << "the newest alone";
}

TEST_F(MeasurementStoreTest, KeepsAllWithoutAFolder) {
  MeasurementStore store({one_, {}});
  fill(store, 5);
  EXPECT_EQ(store.bytes_in_memory(), 5 * one_);
  expect_all_there(store);
}

TEST_F(MeasurementStoreTest, MeasuresWhatWasStoredOnceAndWhenItIsAskedFor) {
  MeasurementStore store({2 * one_, folder_.path()});
  std::vector<KeyframeId> measured;
  store.add_stored(3, [&](KeyframeId id) -> Expected<motion::FrameMeasurements> {
    measured.push_back(id);
    return measurements_of(id);
  });
  ASSERT_OK(store.add(measurements_of(3)));
  EXPECT_THAT(measured, ::testing::IsEmpty());
  ASSERT_OK(store.get(1));
  EXPECT_THAT(measured, ::testing::ElementsAre(1U));
  expect_all_there(store);
  expect_all_there(store);
  EXPECT_THAT(measured, ::testing::ElementsAre(1U, 0U, 2U));
  EXPECT_LE(store.bytes_in_memory(), 2 * one_);
}

TEST_F(MeasurementStoreTest, NamesAFolderThatIsNotThere) {
  MeasurementStore store({one_, folder_ / "nowhere"});
  ASSERT_OK(store.add(measurements_of(0)));
  EXPECT_ERROR(store.add(measurements_of(1)), "nowhere: no scratch file can be made there");
}

}  // namespace
}  // namespace roomwise::mapping
