#include "laboratory/trials/naive_objects.h"

#include <gtest/gtest.h>

namespace roomwise::trials {
namespace {

using objects::DetectionSource;

class NaiveObjectsTest : public ::testing::Test {
 protected:
  // A key-frame one metre further along x each time, which sees boxes at these places of the world.
  void see(std::initializer_list<std::tuple<const char*, float, Eigen::Vector3d>> boxes,
           DetectionSource source = DetectionSource::kDetector) {
    objects::ObservedKeyframe& keyframe = keyframes_.emplace_back();
    keyframe.keyframe_id = keyframes_.size();
    keyframe.world_from_camera.translation = {static_cast<double>(keyframes_.size()), 0, 0};
    for (const auto& [class_name, score, place_world] : boxes) {
      objects::Detection& detection = keyframe.detections.emplace_back();
      detection.class_name = class_name;
      detection.score = score;
      detection.source = source;
      const Eigen::Vector3f middle =
          (keyframe.world_from_camera.inverse() * place_world).cast<float>();
      // The middle, and as many points to each side; one lies far behind.
      detection.surface.points = {middle - Eigen::Vector3f(0.1F, 0, 0), middle,
                                  middle + Eigen::Vector3f(0, 0, 9)};
    }
  }

  std::vector<objects::ObservedKeyframe> keyframes_;
};

TEST_F(NaiveObjectsTest, BoxesOfOneClassInOnePlaceAreOneThingAtTheirMean) {
  for (const double x : {2.0, 2.1, 2.2, 2.3}) see({{"chair", 0.6F, {x, 1, 0}}});
  const auto found = naive_objects(keyframes_);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].kind, "chair");
  EXPECT_LT((found[0].position - Eigen::Vector3d(2.15, 1, 0)).norm(), 1e-5);
}

TEST_F(NaiveObjectsTest, WhatStandsFurtherApartAndWhatIsCalledOtherwiseAreThingsOfTheirOwn) {
  for (int k = 0; k < 4; ++k) {
    see({{"chair", 0.6F, {2, 1, 0}}, {"chair", 0.5F, {2.4, 1, 0}}, {"table", 0.5F, {2, 1, 0}}});
  }
  EXPECT_EQ(naive_objects(keyframes_).size(), 3U);
}

TEST_F(NaiveObjectsTest, FourKeyframesMustShowItAndOneMustBeSure) {
  for (int k = 0; k < 3; ++k) see({{"cup", 0.9F, {0, 0, 1}}, {"cup", 0.8F, {0.1, 0, 1}}});
  EXPECT_TRUE(naive_objects(keyframes_).empty()) << "six boxes, but three key-frames";
  see({{"cup", 0.2F, {0, 0, 1}}});
  EXPECT_EQ(naive_objects(keyframes_).size(), 1U);

  keyframes_.clear();
  for (int k = 0; k < 9; ++k) see({{"cup", 0.49F, {0, 0, 1}}});
  EXPECT_TRUE(naive_objects(keyframes_).empty()) << "none was sure";
}

TEST_F(NaiveObjectsTest, OnlyADetectorsBoxesWithASurfaceAndAWordCount) {
  for (int k = 0; k < 4; ++k) see({{"sink", 0.9F, {0, 0, 1}}}, DetectionSource::kProposal);
  EXPECT_TRUE(naive_objects(keyframes_).empty());

  keyframes_.clear();
  for (int k = 0; k < 4; ++k) see({{"sink", 0.9F, {0, 0, 1}}, {"radiator", 0.9F, {3, 0, 1}}});
  for (auto& keyframe : keyframes_) {
    keyframe.detections[0].surface.points.clear();
    keyframe.detections[1].is_in_vocabulary = false;
  }
  EXPECT_TRUE(naive_objects(keyframes_).empty());
}

}  // namespace
}  // namespace roomwise::trials
