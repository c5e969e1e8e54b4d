#include "roomwise/mapping/localization/lens_calibration.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

namespace roomwise::mapping {
namespace {

using geometry::RigidTransform;
using motion::IntrinsicsEstimate;

// What the localiser says of a picture that was asked with `asked` and whose points measured a
// focal length, over the longer side, to `sigma` of it.
Localization answer(const IntrinsicsEstimate& asked, double focal, double sigma, double x_m,
                    LocalizationStatus status = LocalizationStatus::kFound) {
  Localization found;
  found.status = status;
  found.world_from_camera.translation = {x_m, 0, 0};
  const Eigen::Matrix2d measured = Eigen::Vector2d(1 / (sigma * sigma), 1e4).asDiagonal();
  IntrinsicsEstimate both;
  both.information = asked.information + measured;
  both.mean = both.information.inverse() *
              (asked.information * asked.mean + measured * Eigen::Vector2d(std::log(focal), 0));
  found.lens = both;
  return found;
}
double focal(const LensCalibration& lens) {
  return std::exp(lens.known().mean[0]);
}

TEST(LensCalibration, LearnsFromViewToView) {
  LensCalibration lens;
  double sigma_before = lens.known().relative_focal_sigma();
  for (int view = 0; view < 4; ++view) {
    lens.add(answer(lens.estimate(), view % 2 == 0 ? 0.69 : 0.71, 0.03, view));
    EXPECT_LT(lens.known().relative_focal_sigma(), sigma_before);
    sigma_before = lens.known().relative_focal_sigma();
  }
  EXPECT_NEAR(focal(lens), 0.70, 0.005);
}

TEST(LensCalibration, CountsAViewOnce) {
  LensCalibration lens;
  lens.add(answer(lens.estimate(), 0.7, 0.03, 0));
  const double sigma = lens.known().relative_focal_sigma();
  for (int picture = 0; picture < 20; ++picture)
    lens.add(answer(lens.estimate(), 0.7, 0.03, 0.01 * picture));
  EXPECT_EQ(lens.known().relative_focal_sigma(), sigma);
}

TEST(LensCalibration, GoesOnWhereAnotherLeftOff) {
  LensCalibration before;
  before.add(answer(before.estimate(), 0.7, 0.03, 0));
  LensCalibration after(before.known(), before.counted());
  EXPECT_FALSE(after.add(answer(after.estimate(), 0.7, 0.03, 0))) << "it counted this view";
  EXPECT_EQ(after.known().mean, before.known().mean);
  EXPECT_TRUE(after.add(answer(after.estimate(), 0.7, 0.03, 1)));
}

TEST(LensCalibration, KeepsTheLatestViews) {
  LensCalibration lens;
  for (int view = 0; view < 300; ++view) lens.add(answer(lens.estimate(), 0.7, 0.05, view));
  EXPECT_EQ(lens.counted().size(), 200U);
  EXPECT_EQ(lens.counted().back().translation.x(), 299);
}

TEST(LensCalibration, DoesNotBelieveOnePictureToItsWord) {
  LensCalibration lens;
  lens.add(answer(lens.estimate(), 0.7, 1e-4, 0));
  EXPECT_GT(lens.known().relative_focal_sigma(), 0.015);
}

TEST(LensCalibration, IsNeverSurerThanLensesBreathe) {
  LensCalibration lens;
  for (int view = 0; view < 500; ++view) lens.add(answer(lens.estimate(), 0.7, 0.01, view));
  EXPECT_NEAR(lens.known().relative_focal_sigma(), 0.01, 1e-9);
  EXPECT_NEAR(focal(lens), 0.7, 1e-3);
}

TEST(LensCalibration, LearnsNothingFromADoubtfulPose) {
  LensCalibration lens;
  for (const auto status : {LocalizationStatus::kDoubtful, LocalizationStatus::kAmbiguous,
                            LocalizationStatus::kNoMotion, LocalizationStatus::kContradicted}) {
    lens.add(answer(lens.estimate(), 0.5, 0.01, 0, status));
    EXPECT_EQ(lens.known().mean, IntrinsicsEstimate::typical_of_phones().mean);
  }
}

TEST(LensCalibration, AVaguePoseSaysWhatItKnowsOfTheLens) {
  LensCalibration lens;
  lens.add(answer(lens.estimate(), 0.7, 0.05, 0, LocalizationStatus::kVague));
  EXPECT_LT(lens.known().relative_focal_sigma(), 0.06);
}

class LensCalibrationAfterAnotherLens : public ::testing::Test {
 protected:
  void SetUp() override {
    for (int view = 0; view < 8; ++view) lens_.add(answer(lens_.estimate(), 0.7, 0.02, view));
  }
  void find_nothing(int pictures) {
    for (int i = 0; i < pictures; ++i) {
      lens_.add(answer(lens_.estimate(), 0.7, 0.02, 0, LocalizationStatus::kNoMotion));
    }
  }
  LensCalibration lens_;
};

TEST_F(LensCalibrationAfterAnotherLens, AsksAnewAfterManyPicturesWithoutAPose) {
  find_nothing(9);
  EXPECT_LT(lens_.estimate().relative_focal_sigma(), 0.02);
  find_nothing(1);
  EXPECT_EQ(lens_.estimate().relative_focal_sigma(),
            IntrinsicsEstimate::typical_of_phones().relative_focal_sigma());
}

TEST_F(LensCalibrationAfterAnotherLens, StartsAnewWhereThereIsOne) {
  find_nothing(10);
  lens_.add(answer(lens_.estimate(), 0.4, 0.02, 20));
  EXPECT_NEAR(focal(lens_), 0.4, 0.02);
}

TEST_F(LensCalibrationAfterAnotherLens, KeepsWhatItKnewWhereThereIsNone) {
  find_nothing(10);
  lens_.add(answer(lens_.estimate(), 0.7, 0.02, 20));
  EXPECT_NEAR(focal(lens_), 0.7, 0.005);
  EXPECT_LT(lens_.known().relative_focal_sigma(), 0.015);
  EXPECT_LT(lens_.estimate().relative_focal_sigma(), 0.015);
}

}  // namespace
}  // namespace roomwise::mapping
