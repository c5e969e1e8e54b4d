#include "roomwise/motion/frame_locator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "roomwise/base/testing/testing.h"
#include "roomwise/motion/testing/test_scenes.h"

namespace roomwise::motion {
namespace {

using geometry::RigidTransform;
using testing::box_room;
using testing::common_features;
using testing::CommonFeatures;
using ::testing::HasSubstr;
using testing::kCamera;
using testing::kMotion;
using testing::kStart;
using testing::motion_by;
using testing::view_of;
using testing::wall;

MeasuredFeatures no_features() {
  MeasuredFeatures none;
  none.features.descriptors = features::FloatDescriptors(0, 64);
  return none;
}
FrameMeasurements without_asking_for_features(const RgbdPyramid& view) {
  return {view, [] {
            ADD_FAILURE() << "features were asked for";
            return no_features();
          }};
}
MotionOutcome locate(const FrameMeasurements& reference, const FrameMeasurements& current,
                     const std::optional<PosePrior>& prior, const LocatorOptions& options = {}) {
  return locate_frame(reference, current, prior, kCamera, options, RandomStream(1));
}
double error_m(const MotionOutcome& outcome, const RigidTransform& truth = kMotion) {
  return (truth.inverse() * outcome.pose.reference_from_current).distance_m();
}

class LocateFrame : public ::testing::Test {
 protected:
  static inline const RgbdPyramid kReference = view_of(box_room(), kStart);
  static inline const RgbdPyramid kCurrent = view_of(box_room(), kStart* kMotion);
  // What the features say if the motion were another.
  static CommonFeatures features_of(const RigidTransform& motion, int count) {
    return common_features(box_room(), kStart, kStart * motion, count);
  }
  static void add_noise(MeasuredFeatures& features, double sigma_px) {
    RandomStream random(3);
    for (Eigen::Vector2d& pixel : features.pixels)
      pixel += sigma_px * Eigen::Vector2d(random.normal(), random.normal());
  }
};

TEST_F(LocateFrame, NeedsNoFeaturesWhereTheViewsLeaveNoDoubt) {
  const MotionOutcome outcome = locate(
      without_asking_for_features(kReference), without_asking_for_features(kCurrent),
      PosePrior::around(kMotion * motion_by({-0.01, -0.02, 0}, {-0.02, 0, -0.01}), 0.05, 0.08));
  ASSERT_TRUE(outcome.found()) << outcome.describe();
  EXPECT_LT(error_m(outcome), 0.002);
  EXPECT_EQ(outcome.inliers, 0);
}

TEST_F(LocateFrame, WithoutAPriorFeaturesDecideAndTheViewsRefine) {
  CommonFeatures common = features_of(kMotion, 40);
  add_noise(common.current, 1);
  const MotionOutcome by_features =
      estimate_motion(common.reference, common.current, kCamera, {}, RandomStream(1));
  ASSERT_TRUE(by_features.found());
  const MotionOutcome outcome =
      locate({common.reference, kReference}, {common.current, kCurrent}, std::nullopt);
  ASSERT_TRUE(outcome.found()) << outcome.describe();
  EXPECT_EQ(outcome.inliers, by_features.inliers);
  EXPECT_LT(error_m(outcome), 0.004);
  EXPECT_LT(error_m(outcome), 0.5 * error_m(by_features)) << "or the views did nothing";
}

TEST_F(LocateFrame, WithoutAPriorOrFeaturesThereIsNoPose) {
  EXPECT_EQ(locate({no_features(), kReference}, {no_features(), kCurrent}, std::nullopt).status,
            MotionStatus::kTooFewFeatures);
}

TEST_F(LocateFrame, FeaturesThatTheDepthContradictsAreNotBelieved) {
  // As a poster seen twice would make it.
  const CommonFeatures wrong = features_of(kMotion * motion_by({0, 0.2, 0}, {0.3, 0, 0.4}), 100);
  ASSERT_TRUE(
      estimate_motion(wrong.reference, wrong.current, kCamera, {}, RandomStream(1)).found());
  const MotionOutcome outcome =
      locate({wrong.reference, kReference}, {wrong.current, kCurrent}, std::nullopt);
  EXPECT_EQ(outcome.status, MotionStatus::kContradicted);
  EXPECT_THAT(outcome.describe(), HasSubstr("contradict"));
  EXPECT_THAT(outcome.describe(), HasSubstr("of 100 matches"));
}

TEST_F(LocateFrame, FewFeaturesDoNotOutweighThePrior) {
  const PosePrior elsewhere =
      PosePrior::around(kMotion * motion_by({0, 0.4, 0}, {0.3, 0, 0}), 0.03, 0.05);
  const CommonFeatures few = features_of(kMotion, 30);
  const MotionOutcome surprising =
      locate({few.reference, kReference}, {few.current, kCurrent}, elsewhere);
  EXPECT_EQ(surprising.status, MotionStatus::kContradictsPrior);
  EXPECT_THAT(surprising.describe(), HasSubstr("predicted"));

  const CommonFeatures many = features_of(kMotion, 80);
  const MotionOutcome outcome =
      locate({many.reference, kReference}, {many.current, kCurrent}, elsewhere);
  ASSERT_TRUE(outcome.found()) << outcome.describe();
  EXPECT_LT(error_m(outcome), 0.002);
}

TEST_F(LocateFrame, AnAlignmentFarFromThePriorIsNone) {
  // The views fit at the truth, which is six sigmas away.
  const PosePrior prior =
      PosePrior::around(kMotion * motion_by({0, 0, 0}, {0.12, 0, 0}), 0.02, 0.05);
  const ViewAlignment alignment = align_views(kReference, kCurrent, prior);
  ASSERT_TRUE(alignment.found);
  ASSERT_GT(squared_mahalanobis(alignment.pose.reference_from_current, prior), 20);
  EXPECT_FALSE(locate({no_features(), kReference}, {no_features(), kCurrent}, prior).found());
}

TEST(LocateFrameAtAWall, BelievesThePriorsAlignmentALittleWhereNothingElseIsSeen) {
  const RigidTransform motion = motion_by({0.02, 0, 0}, {0.03, 0, 0.04});
  const RgbdPyramid reference = view_of(wall(1.8), RigidTransform::identity());
  const RgbdPyramid current = view_of(wall(1.8), motion);
  const PosePrior prior = PosePrior::around(motion, 0.03, 0.05);
  int asked = 0;
  const FrameMeasurements bare(current, [&asked] {
    ++asked;
    return no_features();
  });
  const MotionOutcome outcome = locate({no_features(), reference}, bare, prior);
  EXPECT_EQ(asked, 1) << "features might have said more";
  ASSERT_TRUE(outcome.found()) << outcome.describe();
  const ViewAlignment alignment = align_views(reference, current, prior);
  EXPECT_EQ(outcome.pose.reference_from_current.translation,
            alignment.pose.reference_from_current.translation);
  EXPECT_LT((49 * outcome.pose.information - alignment.pose.information).norm(),
            1e-9 * alignment.pose.information.norm());
}

TEST(LocateFrameAtAWall, FeaturesSayWhereAlongTheWall) {
  const RigidTransform motion = motion_by({0.02, 0, 0}, {0.1, 0, 0.04});
  const CommonFeatures common = common_features(wall(1.8), {}, motion, 60);
  const PosePrior prior = PosePrior::around(motion_by({0, 0, 0}, {0.06, 0.03, 0}), 0.05, 0.05);
  const MotionOutcome outcome = locate({common.reference, view_of(wall(1.8), {})},
                                       {common.current, view_of(wall(1.8), motion)}, prior);
  ASSERT_TRUE(outcome.found()) << outcome.describe();
  EXPECT_GE(outcome.inliers, 55);
  EXPECT_LT(error_m(outcome, motion), 0.005);
}

TEST(LocateFrameAtAWall, FeaturesDecideBetweenTwoPlacesThatLookAlike) {
  const auto stripes = [](const Eigen::Vector3d& p) {
    return 130 + 60 * std::sin(2 * M_PI / 0.4 * p.x()) + 30 * std::sin(7 * p.y());
  };
  const RigidTransform motion = motion_by({0, 0, 0}, {0.41, 0, 0});
  const RgbdPyramid reference = view_of(wall(1.8, stripes), RigidTransform::identity());
  const RgbdPyramid current = view_of(wall(1.8, stripes), motion);
  PosePrior prior = PosePrior::around(RigidTransform::identity(), 0.3, 0.1);
  prior.other_start = motion;
  ASSERT_TRUE(align_views(reference, current, prior).is_ambiguous);
  // What else could leave a doubt is allowed for.
  LocatorOptions options;
  options.sure_sigma = 0.1;
  options.sure_squared_mahalanobis = 1e3;
  const CommonFeatures common = common_features(wall(1.8, stripes), {}, motion, 60);
  int asked = 0;
  const auto measure = [&] {
    ++asked;
    return common.current;
  };
  const MotionOutcome outcome =
      locate({common.reference, reference}, {current, measure}, prior, options);
  EXPECT_EQ(asked, 1);
  ASSERT_TRUE(outcome.found()) << outcome.describe();
  EXPECT_LT(error_m(outcome, motion), 0.005);
  // With a single start there is nothing to choose from.
  prior.other_start.reset();
  EXPECT_TRUE(locate(without_asking_for_features(reference), without_asking_for_features(current),
                     prior, options)
                  .found());
}

// A wall whose pattern repeats, before which the camera moves by a period and a half; a slow change
// of brightness along it tells the periods apart.
class LocateFrameAtARepeatedPattern : public ::testing::Test {
 protected:
  static constexpr double kPeriod_m = 0.2;
  static double brightness(const Eigen::Vector3d& p) {
    return 130 + 50 * std::sin(2 * M_PI / kPeriod_m * p.x()) + 30 * std::sin(7 * p.y()) +
           25 * std::sin(1.5 * p.x());
  }
  static inline const RigidTransform kAlong = motion_by({0, 0, 0}, {0.3, 0, 0});
  static inline const RgbdPyramid kReference = view_of(wall(1.8, brightness), {});
  static inline const RgbdPyramid kCurrent = view_of(wall(1.8, brightness), kAlong);
  // What could leave another doubt is allowed for.
  static LocatorOptions unsuspecting() {
    LocatorOptions options;
    options.sure_sigma = 0.1;
    options.sure_rms = options.max_rms = 5;
    return options;
  }
  static PosePrior predicted(double along_m) {
    return PosePrior::around(motion_by({0, 0, 0}, {along_m, 0, 0}), 0.15, 0.1);
  }
  static CommonFeatures features_of(double along_m) {
    return common_features(wall(1.8, brightness), {}, motion_by({0, 0, 0}, {along_m, 0, 0}), 40);
  }
};

TEST_F(LocateFrameAtARepeatedPattern, FeaturesPutRightViewsThatFitAPeriodOff) {
  const PosePrior prior = predicted(0.3 - 0.85 * kPeriod_m);
  const MotionOutcome blind =
      locate({no_features(), kReference}, {no_features(), kCurrent}, prior, unsuspecting());
  ASSERT_TRUE(blind.found());
  ASSERT_NEAR(error_m(blind, kAlong), kPeriod_m, 0.02) << "or the scene deceives nobody";
  const CommonFeatures right = features_of(0.3);
  const MotionOutcome outcome =
      locate({right.reference, kReference}, {right.current, kCurrent}, prior, unsuspecting());
  ASSERT_TRUE(outcome.found());
  EXPECT_LT(error_m(outcome, kAlong), 0.003);
  EXPECT_GT(outcome.inliers, 30);
}

TEST_F(LocateFrameAtARepeatedPattern, ViewsThatFitBetterStandAgainstFeaturesAPeriodOff) {
  const CommonFeatures wrong = features_of(0.3 - kPeriod_m);
  const MotionOutcome outcome = locate({wrong.reference, kReference}, {wrong.current, kCurrent},
                                       predicted(0.29), unsuspecting());
  ASSERT_TRUE(outcome.found());
  EXPECT_LT(error_m(outcome, kAlong), 0.003);
}

TEST_F(LocateFrameAtARepeatedPattern, FeaturesThatSayTheSameChangeNothing) {
  const MotionOutcome alone = locate({no_features(), kReference}, {no_features(), kCurrent},
                                     predicted(0.29), unsuspecting());
  ASSERT_LT(error_m(alone, kAlong), 0.003);
  const CommonFeatures nearly = features_of(0.31);
  const MotionOutcome outcome = locate({nearly.reference, kReference}, {nearly.current, kCurrent},
                                       predicted(0.29), unsuspecting());
  EXPECT_EQ(outcome.pose.reference_from_current.translation,
            alone.pose.reference_from_current.translation);
  EXPECT_EQ(outcome.inliers, 0);
}

TEST_F(LocateFrameAtARepeatedPattern, AfterASmallMotionNothingIsConfirmed) {
  const RgbdPyramid near = view_of(wall(1.8, brightness), motion_by({0, 0, 0}, {0.05, 0, 0}));
  EXPECT_TRUE(locate(without_asking_for_features(kReference), without_asking_for_features(near),
                     predicted(0.06), unsuspecting())
                  .found());
}

TEST(LocatorOptions, SaysWhichFieldIsWrong) {
  LocatorOptions options;
  EXPECT_OK(options.validate());
  options.max_rms = 1;
  EXPECT_ERROR(options.validate(), "max_rms = 1");
  options = {};
  options.sure_sigma = 0;
  EXPECT_ERROR(options.validate(), "sure_sigma");
  options = {};
  options.cross_check_min_rotation_rad = 0;
  EXPECT_ERROR(options.validate(), "cross_check_min_rotation_rad");
  options = {};
  options.features.confidence = 1;
  EXPECT_ERROR(options.validate(), "confidence");
  options = {};
  options.views.gray_sigma = -1;
  EXPECT_ERROR(options.validate(), "gray_sigma");
}

}  // namespace
}  // namespace roomwise::motion
