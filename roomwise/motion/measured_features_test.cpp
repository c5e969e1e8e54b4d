#include "roomwise/motion/measured_features.h"

#include <gtest/gtest.h>

namespace roomwise::motion {
namespace {

const geometry::PinholeCamera kFr1Camera = geometry::camera_preset("fr1").value();

features::Features one_feature(float x, float y) {
  features::Features features;
  features.keypoints.push_back({});
  features.keypoints.back().position_px = {x, y};
  features.descriptors = features::FloatDescriptors(1, 64);
  return features;
}

TEST(MeasureFeatures, GivesThePointThatThePixelSees) {
  const image::DepthImage depth(640, 480, 10'000);  // 2 m at 5000 units per metre
  const auto measured = measure_features(one_feature(500, 100), depth, kFr1Camera);
  ASSERT_TRUE(measured.has_point(0));
  EXPECT_NEAR(measured.points[0].z(), 2.0, 1e-12);
  EXPECT_LT((kFr1Camera.project(measured.points[0]) - Eigen::Vector2d(500, 100)).norm(), 1e-6);
  EXPECT_LT((kFr1Camera.project_undistorted(measured.points[0]) - measured.pixels[0]).norm(), 1e-9);
}

TEST(MeasureFeatures, HasNoPointWhereDepthIsMissingTornOrFar) {
  const auto has_point = [](const image::DepthImage& depth) {
    return measure_features(one_feature(320, 240), depth, kFr1Camera).has_point(0);
  };
  EXPECT_FALSE(has_point(image::DepthImage(640, 480, 0)));
  EXPECT_FALSE(has_point(image::DepthImage(640, 480, 50'000))) << "10 m";
  image::DepthImage edge(640, 480, 10'000);
  for (int y = 0; y < 480; ++y) edge.at(321, y) = 12'000;
  EXPECT_FALSE(has_point(edge));
  image::DepthImage speck(640, 480, 0);
  speck.at(320, 240) = 10'000;
  EXPECT_FALSE(has_point(speck)) << "a single measured pixel may be noise";
}

TEST(MeasureFeatures, WorksAtTheBorder) {
  const image::DepthImage depth(640, 480, 10'000);
  EXPECT_TRUE(measure_features(one_feature(0, 0), depth, kFr1Camera).has_point(0));
  EXPECT_TRUE(measure_features(one_feature(639, 479), depth, kFr1Camera).has_point(0));
}

}  // namespace
}  // namespace roomwise::motion
