#include "roomwise/motion/frame_measurements.h"

#include <gtest/gtest.h>

#include <memory>

#include "roomwise/motion/testing/test_scenes.h"

namespace roomwise::motion {
namespace {

MeasuredFeatures so_many_features(int count) {
  const geometry::RigidTransform still;
  return testing::common_features(testing::wall(2), still, still, count).current;
}

TEST(FrameMeasurements, FindsFeaturesOnceWhenFirstAskedFor) {
  int calls = 0;
  const FrameMeasurements measurements(RgbdPyramid(), [&calls] {
    ++calls;
    return so_many_features(3);
  });
  EXPECT_EQ(calls, 0);
  EXPECT_EQ(measurements.features().size(), 3U);
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(&measurements.features(), &measurements.features());
  const FrameMeasurements copy = measurements;
  EXPECT_EQ(copy.features().size(), 3U);
  EXPECT_EQ(calls, 1);
}

TEST(FrameMeasurements, LetsGoOfTheImageWhenFeaturesAreFound) {
  auto image = std::make_shared<int>(7);
  const FrameMeasurements measurements(RgbdPyramid(), [image] { return so_many_features(*image); });
  EXPECT_EQ(image.use_count(), 2);
  EXPECT_EQ(measurements.features().size(), 7U);
  EXPECT_EQ(image.use_count(), 1);
}

TEST(FrameMeasurements, HoldsFeaturesWithOrWithoutAView) {
  const FrameMeasurements features_only = so_many_features(5);
  EXPECT_EQ(features_only.features().size(), 5U);
  EXPECT_TRUE(features_only.view().empty());
  const FrameMeasurements both(
      so_many_features(5),
      testing::view_of(testing::wall(2), geometry::RigidTransform::identity()));
  EXPECT_EQ(both.view().levels.size(), 3U);
}

}  // namespace
}  // namespace roomwise::motion
