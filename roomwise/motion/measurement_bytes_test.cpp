#include "roomwise/motion/measurement_bytes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/motion/testing/test_scenes.h"

namespace roomwise::motion {
namespace {

MeasuredFeatures made_up_features(std::size_t count, bool is_real) {
  RandomStream random(7);
  MeasuredFeatures measured;
  for (std::size_t i = 0; i < count; ++i) {
    features::Keypoint keypoint;
    keypoint.position_px = {static_cast<float>(random.uniform()), 3.5F};
    keypoint.size_px = 9;
    keypoint.angle_rad = -1.25F;
    keypoint.response = static_cast<float>(random.normal());
    keypoint.bright = i % 3 == 0;
    measured.features.keypoints.push_back(keypoint);
    measured.pixels.emplace_back(random.normal(), 1.0 / 3);
    measured.points.emplace_back(random.normal(), -0.0, random.normal());
  }
  const auto rows = static_cast<Eigen::Index>(count);
  if (is_real) {
    measured.features.descriptors = features::FloatDescriptors(
        features::FloatDescriptors::NullaryExpr(rows, 64, [&](Eigen::Index, Eigen::Index) {
          return static_cast<float>(random.normal());
        }));
  } else {
    measured.features.descriptors = features::BinaryDescriptors(
        features::BinaryDescriptors::NullaryExpr(rows, 32, [&](Eigen::Index, Eigen::Index) {
          return static_cast<std::uint8_t>(random.index(256));
        }));
  }
  return measured;
}

RgbdPyramid made_up_view() {
  return testing::view_of(
      [](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
        const double length = (2 - origin.z()) / direction.z();
        return testing::Sight{length, testing::marbled(origin + length * direction)};
      },
      geometry::RigidTransform::identity());
}

void expect_same(const FrameMeasurements& a, const FrameMeasurements& b) {
  ASSERT_EQ(a.view().levels.size(), b.view().levels.size());
  for (std::size_t i = 0; i < a.view().levels.size(); ++i) {
    EXPECT_EQ(a.view().levels[i].camera, b.view().levels[i].camera);
    EXPECT_EQ(a.view().levels[i].gray, b.view().levels[i].gray);
    EXPECT_EQ(a.view().levels[i].depth, b.view().levels[i].depth);
  }
  EXPECT_EQ(a.features().features.descriptors, b.features().features.descriptors);
  EXPECT_EQ(a.features().pixels, b.features().pixels);
  EXPECT_EQ(a.features().points, b.features().points);
  ASSERT_EQ(a.features().size(), b.features().size());
  for (std::size_t i = 0; i < a.features().size(); ++i) {
    const features::Keypoint& one = a.features().features.keypoints[i];
    const features::Keypoint& other = b.features().features.keypoints[i];
    EXPECT_EQ(one.position_px, other.position_px);
    EXPECT_EQ(one.size_px, other.size_px);
    EXPECT_EQ(one.angle_rad, other.angle_rad);
    EXPECT_EQ(one.response, other.response);
    EXPECT_EQ(one.bright, other.bright);
  }
}

TEST(MeasurementBytes, ComeBackToTheBit) {
  for (const bool is_real : {true, false}) {
    for (const std::size_t count : {0U, 1U, 50U}) {
      const FrameMeasurements measured(made_up_features(count, is_real), made_up_view());
      const auto again = measurements_from_bytes(to_bytes(measured));
      ASSERT_OK(again);
      expect_same(*again, measured);
      // So does the sign of a zero.
      EXPECT_EQ(to_bytes(*again), to_bytes(measured));
    }
  }
  const FrameMeasurements without_view(made_up_features(3, true));
  const auto again = measurements_from_bytes(to_bytes(without_view));
  ASSERT_OK(again);
  EXPECT_TRUE(again->view().empty());
}

TEST(MeasurementBytes, FindsTheFeatures) {
  const FrameMeasurements later(made_up_view(), [] { return made_up_features(9, true); });
  const auto again = measurements_from_bytes(to_bytes(later));
  ASSERT_OK(again);
  EXPECT_EQ(again->features().size(), 9U);
}

TEST(MeasurementBytes, RefusesWhatItDidNotWrite) {
  const FrameMeasurements measured(made_up_features(20, true), made_up_view());
  Bytes bytes = to_bytes(measured);
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{7}, bytes.size() / 2, bytes.size() - 1}) {
    EXPECT_ERROR(measurements_from_bytes(std::span(bytes).first(size)), "are no measurements");
  }
  bytes.push_back(0);
  EXPECT_ERROR(measurements_from_bytes(bytes), "are no measurements");
}

TEST(MeasurementBytes, KnowsHowMuchMemoryTheyTake) {
  const FrameMeasurements measured(made_up_features(50, true), made_up_view());
  const std::size_t least = 50 * 64 * sizeof(float);
  EXPECT_GT(memory_bytes(measured), least + measured.view().levels[0].gray.pixels().size());
  EXPECT_LT(memory_bytes(measured), 2 * to_bytes(measured).size());
}

}  // namespace
}  // namespace roomwise::motion
