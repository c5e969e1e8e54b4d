#include "roomwise/motion/motion_estimator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/motion/testing/test_scenes.h"

namespace roomwise::motion {
namespace {

using geometry::RigidTransform;
using ::testing::HasSubstr;
using testing::kCamera;

// Two frames that see the same `common` points, with descriptors that tell which is which; `wrong`
// further points carry each other's descriptors but lie anywhere.
struct TwoFrames {
  MeasuredFeatures reference;
  MeasuredFeatures current;
};

TwoFrames two_frames(const RigidTransform& reference_from_current, int common, int wrong,
                     double noise_px, std::uint64_t seed) {
  RandomStream random(seed);
  const int count = common + wrong;
  TwoFrames frames;
  features::FloatDescriptors descriptors(count, 64);
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < 64; ++k) descriptors(i, k) = static_cast<float>(random.normal());
    descriptors.row(i).normalize();
    const Eigen::Vector2d pixel(640 * random.uniform(), 480 * random.uniform());
    const double depth_m = 1 + 3 * random.uniform();
    const Eigen::Vector3d point_current = kCamera.unproject_undistorted(pixel, depth_m);
    const Eigen::Vector3d point_reference =
        i < common
            ? reference_from_current * point_current
            : Eigen::Vector3d(3 * random.normal(), 2 * random.normal(), 1 + 3 * random.uniform());
    const Eigen::Vector2d noise = noise_px * Eigen::Vector2d(random.normal(), random.normal());
    frames.current.pixels.push_back(pixel + noise);
    frames.current.points.push_back(point_current);
    frames.reference.pixels.push_back(kCamera.project_undistorted(point_reference));
    frames.reference.points.push_back(point_reference);
    frames.current.features.keypoints.emplace_back();
    frames.reference.features.keypoints.emplace_back();
  }
  frames.current.features.descriptors = descriptors;
  frames.reference.features.descriptors = descriptors;
  return frames;
}

RigidTransform a_motion() {
  geometry::Vector6d twist;
  twist << 0.1, -0.2, 0.05, 0.2, -0.1, 0.15;
  return RigidTransform::exp(twist);
}

MotionOutcome estimate(const TwoFrames& frames, const MotionOptions& options = {},
                       std::uint64_t seed = 1) {
  return estimate_motion(frames.reference, frames.current, kCamera, options, RandomStream(seed));
}

TEST(EstimateMotion, FindsTheMotionAmongOutliers) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const MotionOutcome outcome = estimate(two_frames(a_motion(), 100, 120, 0.5, seed), {}, seed);
    ASSERT_TRUE(outcome.found()) << outcome.describe();
    const RigidTransform error = a_motion().inverse() * outcome.pose.reference_from_current;
    EXPECT_LT(error.angle_rad(), 0.002);
    EXPECT_LT(error.distance_m(), 0.006);
    EXPECT_NEAR(outcome.inliers, 100, 8);
  }
}

TEST(EstimateMotion, IsTheSameForTheSameSeed) {
  const TwoFrames frames = two_frames(a_motion(), 60, 60, 1.0, 5);
  const MotionOutcome first = estimate(frames, {}, 7);
  const MotionOutcome again = estimate(frames, {}, 7);
  EXPECT_EQ(first.pose.reference_from_current.translation,
            again.pose.reference_from_current.translation);
  EXPECT_EQ(first.pose.information, again.pose.information);
}

TEST(EstimateMotion, SaysWhyThereIsNoPose) {
  EXPECT_EQ(estimate(two_frames(a_motion(), 10, 0, 0, 1)).status, MotionStatus::kTooFewFeatures);

  TwoFrames no_depth = two_frames(a_motion(), 50, 0, 0, 1);
  for (auto& point : no_depth.reference.points) point.setZero();
  const MotionOutcome matches = estimate(no_depth);
  EXPECT_EQ(matches.status, MotionStatus::kTooFewMatches);
  EXPECT_EQ(matches.describe(), "too few matches (0)");

  const MotionOutcome inliers = estimate(two_frames(a_motion(), 0, 80, 0, 1));
  EXPECT_EQ(inliers.status, MotionStatus::kTooFewInliers);
  EXPECT_THAT(inliers.describe(), HasSubstr("of 80 matches"));

  MotionOptions still;
  still.max_translation_m = 0.1;
  const MotionOutcome large = estimate(two_frames(a_motion(), 50, 0, 0, 1), still);
  EXPECT_EQ(large.status, MotionStatus::kMotionTooLarge);
  EXPECT_THAT(large.describe(), HasSubstr("0.27 m"));
}

TEST(MotionOptions, SaysWhichFieldIsWrong) {
  MotionOptions options;
  EXPECT_OK(options.validate());
  options.confidence = 1;
  EXPECT_ERROR(options.validate(), "confidence");
  options = {};
  options.min_matches = 3;
  EXPECT_ERROR(options.validate(), "min_matches");
  options = {};
  options.min_inlier_ratio = 1.5;
  EXPECT_ERROR(options.validate(), "min_inlier_ratio");
  EXPECT_ERROR(DepthRange{.farthest_m = -1}.validate(), "farthest_m");
  EXPECT_ERROR(DepthRange{.max_relative_spread = NAN}.validate(), "max_relative_spread");
}

}  // namespace
}  // namespace roomwise::motion
