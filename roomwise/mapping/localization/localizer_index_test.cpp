#include "roomwise/mapping/localization/localizer_index.h"

#include <gtest/gtest.h>

#include "roomwise/base/random.h"
#include "roomwise/motion/testing/test_scenes.h"

namespace roomwise::mapping {
namespace {

using motion::testing::box_room;
using motion::testing::motion_by;
using motion::testing::view_of;

motion::FrameMeasurements picture(std::uint64_t seed) {
  RandomStream random(seed);
  motion::MeasuredFeatures seen;
  seen.features.descriptors = features::FloatDescriptors::NullaryExpr(
      30, 64, [&](Eigen::Index, Eigen::Index) { return static_cast<float>(random.normal()); });
  seen.features.keypoints.resize(30);
  seen.pixels.resize(30);
  seen.points.resize(30);
  return {seen, view_of(box_room(), motion_by({0, 0.1 * static_cast<double>(seed), 0}, {0, 0, 0}))};
}

TEST(LocalizerIndex, ComesBackFromItsBytes) {
  LocalizerIndex index;
  for (std::uint64_t seed = 0; seed < 12; ++seed) index.add(picture(seed));
  const Bytes bytes = index.to_bytes();
  const auto back = LocalizerIndex::from_bytes(bytes);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->size(), index.size());
  EXPECT_EQ(back->view_camera(), index.view_camera());
  EXPECT_EQ(back->to_bytes(), bytes);
  const motion::FrameMeasurements asked = picture(7);
  const auto looks_like = back->appearances().find(asked.features().features, 0, 12, 1);
  ASSERT_EQ(looks_like.size(), 1U);
  EXPECT_EQ(looks_like.front().id, 7U);
  EXPECT_EQ(back->depths().find(asked.view(), 1).front().index, 7U);
}

TEST(LocalizerIndex, IsWrittenInNoMoreMemoryThanItTakes) {
  LocalizerIndex index;
  for (std::uint64_t seed = 0; seed < 12; ++seed) index.add(picture(seed));
  const Bytes bytes = index.to_bytes();
  EXPECT_EQ(bytes.capacity(), bytes.size());
}

TEST(LocalizerIndex, OfOtherBytesIsNone) {
  LocalizerIndex index;
  index.add(picture(1));
  index.add(picture(2));
  const Bytes bytes = index.to_bytes();
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{9}, bytes.size() / 2, bytes.size() - 1})
    EXPECT_FALSE(LocalizerIndex::from_bytes(std::span(bytes).first(size))) << size;
  Bytes longer = bytes;
  longer.push_back(0);
  EXPECT_FALSE(LocalizerIndex::from_bytes(longer));
}

}  // namespace
}  // namespace roomwise::mapping
