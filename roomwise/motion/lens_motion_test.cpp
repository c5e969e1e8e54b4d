#include "roomwise/motion/lens_motion.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "roomwise/motion/perspective_three_point.h"
#include "roomwise/motion/testing/test_scenes.h"

namespace roomwise::motion {
namespace {

using geometry::PinholeCamera;
using geometry::RigidTransform;

RigidTransform a_pose() {
  geometry::Vector6d twist;
  twist << 0.1, -0.2, 0.05, 0.2, -0.1, 0.15;
  return RigidTransform::exp(twist);
}

// A phone's camera, upright: 480 x 640 px, square pixels, the principal point in the middle.
PinholeCamera phone(double focal_px, double k1 = 0) {
  PinholeCamera camera{focal_px, focal_px, 239.5, 319.5, 480, 640, {}, 1000};
  camera.distortion.k1 = k1;
  return camera;
}

struct View {
  double nearest_m = 1, farthest_m = 4;
  double noise_px = 0.5;
  int right = 80, wrong = 40;
};

// What a camera at a_pose() sees of points at random; the wrong ones lie anywhere.
std::vector<PointObservation> see(const PinholeCamera& camera, std::uint64_t seed,
                                  const View& view = {}) {
  RandomStream random(seed);
  const auto pixel = [&] {
    return Eigen::Vector2d(camera.width * random.uniform(), camera.height * random.uniform());
  };
  std::vector<PointObservation> observations;
  for (int i = 0; i < view.right + view.wrong; ++i) {
    const Eigen::Vector3d point =
        camera.unproject(pixel(), random.between(view.nearest_m, view.farthest_m));
    const Eigen::Vector2d noise = view.noise_px * Eigen::Vector2d(random.normal(), random.normal());
    observations.push_back(
        {a_pose() * point, i < view.right ? camera.project(point) + noise : pixel(), 0});
  }
  return observations;
}

LensMotion find(const std::vector<PointObservation>& observations, std::uint64_t seed = 1,
                const IntrinsicsEstimate& lens = IntrinsicsEstimate::typical_of_phones()) {
  return estimate_motion_and_lens(observations, 480, 640, lens, {}, RandomStream(seed));
}

double error_m(const LensMotion& found) {
  return (a_pose().inverse() * found.motion.pose.reference_from_current).distance_m();
}

TEST(LensMotion, FindsPoseAndFocalLengthAmongWrongMatches) {
  for (const double focal_px : {265.0, 350.0, 500.0, 780.0, 980.0}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const LensMotion found = find(see(phone(focal_px), seed), seed);
      ASSERT_TRUE(found.motion.found()) << found.motion.describe();
      EXPECT_GE(found.motion.inliers, 75);
      EXPECT_NEAR(std::exp(found.lens.mean[0]) * 640 / focal_px, 1, 0.015);
      EXPECT_LT(error_m(found), 0.03);
    }
  }
}

TEST(LensMotion, FindsTheDistortion) {
  const LensMotion found = find(see(phone(450, -0.08), 3));
  ASSERT_TRUE(found.motion.found());
  EXPECT_NEAR(found.lens.mean[1], -0.08, 0.02);
  EXPECT_LT(error_m(found), 0.03);
}

TEST(LensMotion, WithAKnownLensIsAsWithACalibratedCamera) {
  const PinholeCamera camera = phone(500);
  IntrinsicsEstimate known = IntrinsicsEstimate::typical_of_phones();
  known.mean << std::log(500.0 / 640), 0;
  known.information = Eigen::Vector2d(1e12, 1e12).asDiagonal();
  const auto observations = see(camera, 2);
  const LensMotion found = find(observations, 1, known);
  const MotionOutcome calibrated = estimate_motion(observations, camera, {}, RandomStream(1));
  ASSERT_TRUE(found.motion.found());
  EXPECT_EQ(found.motion.inliers, calibrated.inliers);
  const RigidTransform apart =
      found.motion.pose.reference_from_current.inverse() * calibrated.pose.reference_from_current;
  EXPECT_LT(apart.distance_m(), 1e-5);
  EXPECT_TRUE(found.motion.pose.information.isApprox(calibrated.pose.information, 1e-2));
}

// Errors of pose and focal length over what is claimed of them, squared: of a right covariance 6
// and 1 on average.
TEST(LensMotion, ClaimsItsUncertainty) {
  constexpr int kViews = 60;
  for (const View& view : {View{}, View{.nearest_m = 2.9, .farthest_m = 3.1}}) {
    double of_pose = 0, of_focal_length = 0;
    for (std::uint64_t seed = 1; seed <= kViews; ++seed) {
      View noisy = view;
      noisy.noise_px = 1;  // what the residuals' model says
      const LensMotion found = find(see(phone(500), seed, noisy), seed);
      ASSERT_TRUE(found.motion.found());
      const RigidTransform error = a_pose().inverse() * found.motion.pose.reference_from_current;
      geometry::Vector6d edge;
      edge << error.translation, error.rotation.vec();
      of_pose += edge.dot(found.motion.pose.information * edge) / kViews;
      const double off = found.lens.mean[0] - std::log(500.0 / 640);
      of_focal_length += off * off / found.lens.information.inverse()(0, 0) / kViews;
    }
    EXPECT_GT(of_pose, 2);
    EXPECT_LT(of_pose, 12);
    EXPECT_LT(of_focal_length, 2.5);
  }
}

TEST(LensMotion, OfAFlatWallKnowsLittleOfTheFocalLength) {
  const View wall{.nearest_m = 2.999, .farthest_m = 3.001};
  const LensMotion flat = find(see(phone(500), 1, wall));
  const LensMotion deep = find(see(phone(500), 1));
  ASSERT_TRUE(flat.motion.found() && deep.motion.found());
  EXPECT_GT(flat.lens.relative_focal_sigma(), 5 * deep.lens.relative_focal_sigma());
  EXPECT_LT(deep.lens.relative_focal_sigma(), 0.01);
}

TEST(LensMotion, SaysWhyThereIsNone) {
  EXPECT_EQ(find(see(phone(500), 1, {.right = 8, .wrong = 0})).motion.status,
            MotionStatus::kTooFewMatches);
  EXPECT_EQ(find(see(phone(500), 1, {.right = 0, .wrong = 60})).motion.status,
            MotionStatus::kTooFewInliers);
}

image::ExifLens of_35mm(double focal_mm) {
  image::ExifLens exif;
  exif.focal_length_35mm_mm = focal_mm;
  return exif;
}

TEST(LensOfAPhoto, HasTheFocalLengthThatItsExifSays) {
  // 26 mm on 36 mm, or on the diagonal of 43.3 mm: 0.72 or 0.75 of the longer side.
  const auto lens = IntrinsicsEstimate::from_exif(of_35mm(26), 4032, 3024);
  ASSERT_TRUE(lens.has_value());
  const double focal = std::exp(lens->mean[0]);
  EXPECT_GT(focal, 26 / 36.0);
  EXPECT_LT(focal, 26 / 43.27 * 1.25);
  EXPECT_GT(lens->relative_focal_sigma(), 0.03);
  EXPECT_LT(lens->relative_focal_sigma(), 0.06);
  EXPECT_EQ(lens->mean[1], 0);
  EXPECT_EQ(lens->information(1, 1), IntrinsicsEstimate::typical_of_phones().information(1, 1));
  EXPECT_EQ(IntrinsicsEstimate::from_exif(of_35mm(26), 3024, 4032)->mean, lens->mean) << "upright";
}

TEST(LensOfAPhoto, IsLessSureOfAWidePictureThatMayBeCutOutOfTheSensor) {
  EXPECT_GT(IntrinsicsEstimate::from_exif(of_35mm(26), 1920, 1080)->relative_focal_sigma(),
            IntrinsicsEstimate::from_exif(of_35mm(26), 1920, 1440)->relative_focal_sigma());
}

TEST(LensOfAPhoto, MayFollowFromTheSensorsPixels) {
  image::ExifLens exif;
  exif.focal_length_mm = 6;
  exif.pixels_per_mm = 400;
  exif.width = 3000;
  exif.height = 2000;
  EXPECT_NEAR(std::exp(IntrinsicsEstimate::from_exif(exif, 600, 400)->mean[0]), 0.8, 1e-9);
}

TEST(LensOfAPhoto, IsUnsureWhereItsWordsDiffer) {
  image::ExifLens exif = of_35mm(26);
  const double sigma = IntrinsicsEstimate::from_exif(exif, 4032, 3024)->relative_focal_sigma();
  exif.digital_zoom = 2;
  const auto zoomed = IntrinsicsEstimate::from_exif(exif, 4032, 3024);
  EXPECT_GT(zoomed->relative_focal_sigma(), 0.3);
  EXPECT_GT(zoomed->mean[0], IntrinsicsEstimate::from_exif(of_35mm(26), 4032, 3024)->mean[0]);
  EXPECT_LT(sigma, 0.06);
}

TEST(LensOfAPhoto, IsNotKnownOfAPictureThatWasCroppedOrOfNoSuchLens) {
  image::ExifLens exif = of_35mm(26);
  exif.width = 4032;
  exif.height = 3024;
  EXPECT_TRUE(IntrinsicsEstimate::from_exif(exif, 480, 640).has_value())
      << "made smaller and turned";
  EXPECT_FALSE(IntrinsicsEstimate::from_exif(exif, 640, 640).has_value());
  EXPECT_FALSE(IntrinsicsEstimate::from_exif(of_35mm(1), 640, 480).has_value());
  EXPECT_FALSE(IntrinsicsEstimate::from_exif(of_35mm(1000), 640, 480).has_value());
}

// Beyond what is taken for granted of phones a lens is found only where its photo tells of it.
TEST(LensOfAPhoto, FindsThePoseOfATelephotoLens) {
  const PinholeCamera camera = phone(2.2 * 640);
  int without = 0, with = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const auto seen = see(camera, seed);
    without += find(seen, seed).motion.status == MotionStatus::kFound ? 1 : 0;
    const auto lens = IntrinsicsEstimate::from_exif(of_35mm(77), 480, 640);
    const LensMotion found = find(seen, seed, *lens);
    with += found.motion.status == MotionStatus::kFound && error_m(found) < 0.25 ? 1 : 0;
  }
  EXPECT_EQ(with, 8);
  EXPECT_LT(without, 4);
}

TEST(IntrinsicsEstimate, IsTheSameOfAPictureTurned) {
  const IntrinsicsEstimate lens = IntrinsicsEstimate::typical_of_phones();
  const PinholeCamera upright = lens.camera(480, 640), flat = lens.camera(640, 480);
  EXPECT_EQ(upright.fx, flat.fx);
  EXPECT_EQ(upright.fy, flat.fx);
  EXPECT_EQ(upright.cx, flat.cy);
}

}  // namespace
}  // namespace roomwise::motion
