#include "roomwise/mapping/bundle/landmarks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "roomwise/base/testing/testing.h"
#include "roomwise/mapping/testing/feature_walk.h"

namespace roomwise::mapping {
namespace {

using testing::feature_walk;
using testing::poses_of;
using testing::SyntheticScene;

std::vector<Landmark> landmarks_of(const Bundle& bundle, const testing::FeatureWalk& walk) {
  const auto features = testing::small_features(walk, bundle.models[0].camera);
  const auto poses = poses_of(bundle);
  const std::vector<std::size_t> groups(poses.size(), 0);
  const auto pairs = covisible_keyframes(features, poses, groups);
  return find_landmarks(features, poses, pairs);
}

TEST(FindLandmarks, FindsThePointsThatSeveralKeyframesSee) {
  SyntheticScene scene({.noise_sigmas = 0.5});
  const Bundle& truth = scene.truth();
  const auto walk = feature_walk(truth);
  // The poses are known to some pixels.
  const auto landmarks = landmarks_of(scene.guess(0.01, 0.003), walk);
  std::size_t right = 0, views = 0;
  for (const Landmark& landmark : landmarks) {
    ASSERT_GE(landmark.views.size(), 2U);
    std::set<std::size_t> shown;
    for (const LandmarkView& view : landmark.views) {
      const auto& pixels = walk.features[view.camera].pixels;
      const auto feature = std::ranges::find(pixels, view.pixel) - pixels.begin();
      shown.insert(walk.landmark_of[view.camera][static_cast<std::size_t>(feature)]);
    }
    if (shown.size() != 1) continue;
    ++right;
    views += landmark.views.size();
    EXPECT_LT((landmark.point_world - truth.landmarks[*shown.begin()].point_world).norm(), 0.5);
  }
  EXPECT_EQ(right, landmarks.size());
  std::size_t all_views = 0;
  for (const Landmark& landmark : truth.landmarks) all_views += landmark.views.size();
  EXPECT_GT(views, 0.8 * static_cast<double>(all_views));
}

TEST(FindLandmarks, LooksOnlyWhereThePosesExpectAFeature) {
  SyntheticScene scene({});
  const auto walk = feature_walk(scene.truth());
  Bundle wrong = scene.truth();
  for (std::size_t i = 0; i < wrong.cameras.size(); i += 2)
    wrong.cameras[i].world_from_camera.translation.y() += 0.3;
  for (const Landmark& landmark : landmarks_of(wrong, walk)) {
    // Key-frames of the two kinds do not find each other's features.
    for (const LandmarkView& view : landmark.views)
      EXPECT_EQ(view.camera % 2, landmark.views.front().camera % 2);
  }
}

TEST(CovisibleKeyframes, SeeTheSameAndBelongToOneGroup) {
  SyntheticScene scene({});
  const auto features =
      testing::small_features(feature_walk(scene.truth()), scene.truth().models[0].camera);
  auto poses = poses_of(scene.truth());
  std::vector<std::size_t> groups(poses.size(), 0);
  groups.back() = 1;
  poses[3].rotation = poses[3].rotation * Eigen::AngleAxisd(3, Eigen::Vector3d::UnitY());
  const auto pairs = covisible_keyframes(features, poses, groups);
  ASSERT_FALSE(pairs.empty());
  for (const Covisible& pair : pairs) {
    EXPECT_LT(pair.a, pair.b);
    EXPECT_NE(pair.b, poses.size() - 1);
    EXPECT_NE(pair.a, 3U);
    EXPECT_NE(pair.b, 3U);
  }
  LandmarkOptions one;
  one.max_partners = 1;
  const auto fewer = covisible_keyframes(features, poses, groups, one);
  EXPECT_LT(fewer.size(), pairs.size());
  EXPECT_GE(2 * fewer.size(), poses.size() - 2);
}

TEST(KeyframeFeatures, AreTheStrongestInEightBits) {
  SyntheticScene scene({});
  const auto walk = feature_walk(scene.truth());
  LandmarkOptions options;
  options.max_features = 20;
  const auto& measured = walk.features[5];
  const KeyframeFeatures small =
      keyframe_features(measured, scene.truth().models[0].camera, options);
  ASSERT_EQ(small.size(), 20U);
  const auto& descriptors = std::get<features::FloatDescriptors>(measured.features.descriptors);
  for (std::size_t i = 0; i < small.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    EXPECT_EQ(small.views[i].pixel, measured.pixels[i]);
    EXPECT_EQ(small.views[i].depth_m, measured.points[i].z());
    EXPECT_NEAR(small.views[i].row, measured.pixels[i].y() / 479 - 0.5, 1e-6);
    EXPECT_LT((small.descriptors.row(row).cast<float>() / 254 - descriptors.row(row)).norm(),
              0.02F);
  }
}

TEST(KeyframeFeatures, BitsOfBinaryDescriptorsAreSigns) {
  motion::MeasuredFeatures measured;
  measured.features.keypoints.resize(1);
  measured.pixels.assign(1, {10, 10});
  measured.points.assign(1, Eigen::Vector3d::Zero());
  features::BinaryDescriptors bits(1, 2);
  bits << 0b00000101, 0b10000000;
  measured.features.descriptors = bits;
  const KeyframeFeatures small =
      keyframe_features(measured, {500, 500, 320, 240, 640, 480, {}, 1000});
  ASSERT_EQ(small.descriptors.cols(), 16);
  for (Eigen::Index i = 0; i < 16; ++i)
    EXPECT_EQ(small.descriptors(0, i) > 0, i == 0 || i == 2 || i == 15) << i;
  EXPECT_FALSE(small.has_point(0));
}

TEST(KeyframeFeatures, TellTheNormalsOfWhatTheViewShows) {
  const geometry::PinholeCamera camera{200, 200, 79.5, 59.5, 160, 120, {}, 1000};
  const image::GrayImage gray(camera.width, camera.height, 100);
  const image::DepthImage wall(camera.width, camera.height, 2000);
  const auto features_of = [&](const image::DepthImage& depth) {
    return keyframe_features(
        {motion::MeasuredFeatures(), motion::make_rgbd_pyramid(gray, depth, camera)}, camera);
  };
  const KeyframeFeatures seen = features_of(wall);
  ASSERT_GT(seen.normals.size(), 500U);
  for (const Eigen::Vector3f& normal : seen.normals)
    EXPECT_LT((normal - Eigen::Vector3f(0, 0, -1)).norm(), 1e-3F);
  EXPECT_TRUE(features_of(image::DepthImage(camera.width, camera.height, 0)).normals.empty());
  EXPECT_TRUE(keyframe_features(motion::MeasuredFeatures(), camera).normals.empty());
  const motion::FrameMeasurements measured(motion::MeasuredFeatures(),
                                           motion::make_rgbd_pyramid(gray, wall, camera));
  EXPECT_TRUE(keyframe_features(measured, camera, {}, /*with_normals=*/false).normals.empty());
}

TEST(LandmarkOptions, SayWhichIsWrong) {
  LandmarkOptions options;
  EXPECT_OK(options.validate());
  options.search_px = 0;
  EXPECT_ERROR(options.validate(), "search_px");
  options = {};
  options.max_features = 0;
  EXPECT_ERROR(options.validate(), "max_features");
}

}  // namespace
}  // namespace roomwise::mapping
