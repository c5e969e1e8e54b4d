#include "roomwise/motion/view_alignment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "roomwise/base/testing/testing.h"
#include "roomwise/motion/testing/test_scenes.h"

namespace roomwise::motion {
namespace {

using geometry::Matrix6d;
using geometry::RigidTransform;
using geometry::Vector6d;
using testing::box_room;
using testing::kMotion;
using testing::kStart;
using testing::marbled;
using testing::motion_by;
using testing::Picture;
using testing::rgbd_pyramid;
using testing::Scene;
using testing::small_camera;
using testing::view_of;
using testing::wall;

RigidTransform difference(const RigidTransform& truth, const RigidTransform& pose) {
  return truth.inverse() * pose;
}
// As mapping/pose_graph.h has it.
Vector6d edge_error(const RigidTransform& truth, const RigidTransform& pose) {
  const RigidTransform d = difference(pose, truth);
  Vector6d e;
  e << d.translation, d.rotation.vec() * (d.rotation.w() < 0 ? -1 : 1);
  return e;
}
double smallest_eigenvalue(const Matrix6d& matrix) {
  return Eigen::SelfAdjointEigenSolver<Matrix6d>(matrix, Eigen::EigenvaluesOnly).eigenvalues()[0];
}
PosePrior loose_prior(const RigidTransform& pose) {
  return PosePrior::around(pose, 0.1, 0.1);
}
// The camera's noise, in grey levels and in mm at 1 m.
void add_noise(Picture& picture, double gray_sigma, double depth_sigma_m, RandomStream& random) {
  for (std::uint8_t& gray : picture.gray.pixels()) {
    gray = static_cast<std::uint8_t>(
        std::clamp<long>(std::lround(gray + gray_sigma * random.normal()), 0, 255));
  }
  const double units = small_camera().depth_units_per_metre;
  for (std::uint16_t& depth : picture.depth.pixels()) {
    const double metres = depth / units;
    depth = static_cast<std::uint16_t>(
        std::lround(depth + units * depth_sigma_m * metres * metres * random.normal()));
  }
}

class AlignRoomViews : public ::testing::Test {
 protected:
  static inline const RgbdPyramid kReference = view_of(box_room(), kStart);
  static inline const RgbdPyramid kCurrent = view_of(box_room(), kStart* kMotion);
};

TEST_F(AlignRoomViews, FindsTheMotionFromAPriorThatIsOff) {
  for (const RigidTransform& off :
       {RigidTransform(), motion_by({0.05, -0.04, 0.03}, {0.05, 0.04, -0.06}),
        motion_by({-0.04, 0.06, -0.04}, {-0.06, 0.03, 0.05}), kMotion.inverse()}) {
    const ViewAlignment alignment = align_views(kReference, kCurrent, loose_prior(kMotion * off));
    ASSERT_TRUE(alignment.found);
    EXPECT_FALSE(alignment.is_ambiguous);
    const RigidTransform error = difference(kMotion, alignment.pose.reference_from_current);
    EXPECT_LT(error.distance_m(), 0.002);
    EXPECT_LT(error.angle_rad(), 0.001);
    EXPECT_LT(alignment.pose.rms, 0.7);
    EXPECT_GT(alignment.agreement.agreeing, 0.99);
    EXPECT_GT(smallest_eigenvalue(alignment.measured_information), 1 / (0.005 * 0.005));
  }
}

TEST_F(AlignRoomViews, SwappingTheViewsInvertsTheMotion) {
  const ViewAlignment back =
      align_views(kCurrent, kReference, loose_prior(RigidTransform::identity()));
  ASSERT_TRUE(back.found);
  const RigidTransform error = difference(kMotion.inverse(), back.pose.reference_from_current);
  EXPECT_LT(error.distance_m(), 0.002);
  EXPECT_LT(error.angle_rad(), 0.001);
}

TEST_F(AlignRoomViews, DepthAloneIsEnoughInACornerWithoutTexture) {
  const Scene room = box_room(testing::plain);
  // Three walls in view.
  const RigidTransform start = motion_by({-0.35, 0.6, 0}, {-0.3, 0, -0.5});
  const ViewAlignment alignment =
      align_views(view_of(room, start), view_of(room, start * kMotion),
                  loose_prior(kMotion * motion_by({0.03, 0.03, 0}, {0.04, 0, 0.03})));
  ASSERT_TRUE(alignment.found);
  const RigidTransform error = difference(kMotion, alignment.pose.reference_from_current);
  EXPECT_LT(error.distance_m(), 0.004);
  EXPECT_LT(error.angle_rad(), 0.002);
}

TEST_F(AlignRoomViews, GivesTheSameBitsEachTime) {
  const PosePrior prior = loose_prior(RigidTransform::identity());
  const ViewAlignment first = align_views(kReference, kCurrent, prior);
  const ViewAlignment again =
      align_views(RgbdPyramid(kReference), view_of(box_room(), kStart * kMotion), prior);
  EXPECT_EQ(first.pose.reference_from_current.translation,
            again.pose.reference_from_current.translation);
  EXPECT_EQ(first.pose.reference_from_current.rotation.coeffs(),
            again.pose.reference_from_current.rotation.coeffs());
  EXPECT_EQ(first.pose.information, again.pose.information);
  EXPECT_EQ(first.measured_information, again.measured_information);
  EXPECT_EQ(first.pose.rms, again.pose.rms);
}

TEST_F(AlignRoomViews, FindsNothingInWhatTheyDoNotShare) {
  const RgbdPyramid behind = view_of(box_room(), kStart * motion_by({0, M_PI, 0}, {0, 0, 0}));
  EXPECT_FALSE(
      align_views(kReference, behind, loose_prior(motion_by({0, M_PI, 0}, {0, 0, 0}))).found);
  RgbdPyramid blind = kCurrent;
  for (PyramidLevel& level : blind.levels) std::ranges::fill(level.depth.pixels(), 0);
  EXPECT_FALSE(align_views(kReference, blind, loose_prior(kMotion)).found);
  EXPECT_FALSE(align_views(blind, kReference, loose_prior(kMotion)).found);
  EXPECT_FALSE(align_views(kReference, RgbdPyramid(), loose_prior(kMotion)).found);
}

TEST_F(AlignRoomViews, FindsNothingWhereTheDepthsContradict) {
  // The same picture on walls that are half as far away again.
  Picture picture = testing::render(box_room(), small_camera(), kStart * kMotion);
  for (std::uint16_t& depth : picture.depth.pixels()) depth = static_cast<std::uint16_t>(depth / 2);
  EXPECT_FALSE(align_views(kReference, rgbd_pyramid(picture), loose_prior(kMotion)).found);
}

TEST_F(AlignRoomViews, ChangeOfExposureDoesNotMoveThePose) {
  const PosePrior prior = loose_prior(kMotion * motion_by({0.02, 0.02, 0}, {0.03, 0, 0.02}));
  const ViewAlignment plain = align_views(kReference, kCurrent, prior);
  for (const auto& [gain, offset] : {std::pair(1.25, -15.0), std::pair(0.6, 30.0)}) {
    Picture picture = testing::render(box_room(), small_camera(), kStart * kMotion);
    for (std::uint8_t& gray : picture.gray.pixels()) {
      const double brighter = gain * gray + offset;
      ASSERT_TRUE(brighter > 0 && brighter < 255) << "or the test is about saturation";
      gray = static_cast<std::uint8_t>(std::lround(brighter));
    }
    const ViewAlignment alignment = align_views(kReference, rgbd_pyramid(picture), prior);
    ASSERT_TRUE(alignment.found);
    const RigidTransform change =
        difference(plain.pose.reference_from_current, alignment.pose.reference_from_current);
    EXPECT_LT(change.distance_m(), 0.001) << gain;
    EXPECT_LT(change.angle_rad(), 0.0005) << gain;
  }
}

TEST_F(AlignRoomViews, OtherStartWinsWhereThePriorLeadsAstray) {
  const RigidTransform turned = motion_by({0, 0.1, 0.05}, {0.05, 0, 0.1});
  const RgbdPyramid current = view_of(box_room(), kStart * turned);
  // Predicted: a swing that did not happen.
  PosePrior prior = PosePrior::around(turned * motion_by({0, -0.5, 0.3}, {0.3, 0.1, 0}), 0.5, 0.5);
  const auto error_m = [&](const ViewAlignment& alignment) {
    return difference(turned, alignment.pose.reference_from_current).distance_m();
  };
  EXPECT_GT(error_m(align_views(kReference, current, prior)), 0.05);
  prior.other_start = RigidTransform::identity();
  const ViewAlignment helped = align_views(kReference, current, prior);
  ASSERT_TRUE(helped.found);
  EXPECT_FALSE(helped.is_ambiguous);
  EXPECT_LT(error_m(helped), 0.003);
  // And the other way about: a bad other start does no harm to a good prior.
  PosePrior good = loose_prior(turned);
  good.other_start = turned * motion_by({0, -0.5, 0.3}, {0.3, 0.1, 0});
  EXPECT_LT(error_m(align_views(kReference, current, good)), 0.003);
}

// Averaged over noisy pictures, the error must be as large as the information says, give or take
// what the model allows for and these pictures do not have.
TEST_F(AlignRoomViews, InformationCoversTheErrors) {
  RandomStream random(1);
  constexpr int kTrials = 12;
  double sum = 0;
  for (int i = 0; i < kTrials; ++i) {
    Picture reference = testing::render(box_room(), small_camera(), kStart);
    Picture current = testing::render(box_room(), small_camera(), kStart * kMotion);
    add_noise(reference, 3, 0.004, random);
    add_noise(current, 3, 0.004, random);
    const ViewAlignment alignment =
        align_views(rgbd_pyramid(reference), rgbd_pyramid(current),
                    PosePrior::around(kMotion * motion_by({0.02, 0, 0.01}, {0, 0.02, 0}), 1, 1));
    ASSERT_TRUE(alignment.found);
    EXPECT_LT(alignment.pose.rms, 1.5);
    const Vector6d e = edge_error(kMotion, alignment.pose.reference_from_current);
    sum += e.dot(alignment.measured_information * e);
  }
  EXPECT_LT(sum / kTrials, 2 * 6);
  EXPECT_GT(sum / kTrials, 0.1 * 6) << "nor is it far too modest";
}

class AlignWallViews : public ::testing::Test {
 protected:
  // Along the wall the prior is wrong; the wall does not tell. Towards it and in tilt it does.
  static inline const RigidTransform kToWall = motion_by({0.04, -0.03, 0}, {0, 0, 0.05});
  static inline const RigidTransform kPredicted = motion_by({0, 0, 0.02}, {0.05, -0.04, 0.01});
  // In the reference's frame, which looks straight at the wall.
  static Matrix6d in_reference_axes(const Matrix6d& information, const RigidTransform& pose) {
    Matrix6d axes = Matrix6d::Zero();
    axes.topLeftCorner<3, 3>() = pose.rotation_matrix();
    axes.bottomRightCorner<3, 3>() = pose.rotation_matrix();
    return axes * information * axes.transpose();
  }
};

TEST_F(AlignWallViews, ABareWallLeavesThePoseAtThePriorAlongIt) {
  const RgbdPyramid reference = view_of(wall(1.8), RigidTransform::identity());
  const RgbdPyramid current = view_of(wall(1.8), kToWall);
  const ViewAlignment alignment = align_views(reference, current, loose_prior(kPredicted));
  ASSERT_TRUE(alignment.found);
  const RigidTransform& pose = alignment.pose.reference_from_current;
  // What the wall shows: its distance and its tilt.
  EXPECT_NEAR(pose.translation.z(), kToWall.translation.z(), 0.002);
  const Eigen::Vector3d normal = pose.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d truth = kToWall.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  EXPECT_LT((normal - truth).norm(), 0.002);
  // What it does not.
  EXPECT_NEAR(pose.translation.x(), kPredicted.translation.x(), 0.01);
  EXPECT_NEAR(pose.translation.y(), kPredicted.translation.y(), 0.01);
  const Matrix6d seen = in_reference_axes(alignment.measured_information, pose);
  EXPECT_LT(smallest_eigenvalue(alignment.measured_information), 1);
  EXPECT_LT(seen(0, 0), 1e-3 * seen(2, 2));
  EXPECT_LT(seen(1, 1), 1e-3 * seen(2, 2));
  EXPECT_GT(seen(2, 2), 1 / (0.005 * 0.005));
  // The answer's information adds what the prior knows.
  EXPECT_GT(smallest_eigenvalue(alignment.pose.information), 0.5 / (0.1 * 0.1));
}

TEST_F(AlignWallViews, TextureTellsWhereAlongTheWall) {
  const RgbdPyramid reference = view_of(wall(1.8, marbled), RigidTransform::identity());
  const RgbdPyramid current = view_of(wall(1.8, marbled), kToWall);
  const ViewAlignment alignment = align_views(reference, current, loose_prior(kPredicted));
  ASSERT_TRUE(alignment.found);
  const RigidTransform error = difference(kToWall, alignment.pose.reference_from_current);
  EXPECT_LT(error.distance_m(), 0.003);
  EXPECT_LT(error.angle_rad(), 0.002);
}

TEST_F(AlignWallViews, NoiseIsNoTexture) {
  RandomStream random(2);
  const auto noisy = [&](const RigidTransform& pose) {
    Picture picture = testing::render(wall(1.8), small_camera(), pose);
    add_noise(picture, 1, 0, random);
    return rgbd_pyramid(picture);
  };
  const RgbdPyramid reference = noisy(RigidTransform::identity());
  const RgbdPyramid current = noisy(kToWall);
  const auto along_wall = [&](double min_gray_slope) {
    ViewAlignmentOptions options;
    options.min_gray_slope = min_gray_slope;
    const ViewAlignment alignment =
        align_views(reference, current, loose_prior(kPredicted), options);
    return in_reference_axes(alignment.measured_information, alignment.pose.reference_from_current)(
        0, 0);
  };
  EXPECT_LT(along_wall(4), 0.1 * along_wall(0));
}

TEST_F(AlignWallViews, SaysWhenTwoPosesFitAlike) {
  // Stripes every 40 cm: half a metre to the side they look the same.
  const auto stripes = [](const Eigen::Vector3d& p) {
    return 130 + 60 * std::sin(2 * M_PI / 0.4 * p.x()) + 30 * std::sin(7 * p.y());
  };
  const RgbdPyramid reference = view_of(wall(1.8, stripes), RigidTransform::identity());
  const RgbdPyramid current = view_of(wall(1.8, stripes), motion_by({0, 0, 0}, {0.02, 0, 0}));
  PosePrior prior = PosePrior::around(RigidTransform::identity(), 0.5, 0.1);
  EXPECT_FALSE(align_views(reference, current, prior).is_ambiguous) << "only one was tried";
  prior.other_start = motion_by({0, 0, 0}, {0.4, 0, 0});
  EXPECT_TRUE(align_views(reference, current, prior).is_ambiguous);
  prior.other_start = motion_by({0, 0, 0}, {0.03, 0, 0});
  EXPECT_FALSE(align_views(reference, current, prior).is_ambiguous) << "both lead to one pose";
}

TEST(SquaredMahalanobis, GrowsWithTheSquareOfTheDistanceInSigmas) {
  const PosePrior prior = PosePrior::around(kMotion, 0.02, 0.05);
  EXPECT_NEAR(squared_mahalanobis(kMotion, prior), 0, 1e-9);
  EXPECT_NEAR(squared_mahalanobis(kMotion * motion_by({0, 0, 0}, {0.02, 0, 0}), prior), 1, 1e-6);
  EXPECT_NEAR(squared_mahalanobis(kMotion * motion_by({0, 0.05, 0}, {0, 0, 0}), prior), 1, 1e-6);
  EXPECT_NEAR(squared_mahalanobis(kMotion * motion_by({0, 0, 0}, {0, 0, -0.06}), prior), 9, 1e-6);
  EXPECT_NEAR(squared_mahalanobis(kMotion * motion_by({0, 0, 0.1}, {0, 0.02, 0}), prior), 5, 0.01);
  RigidTransform same = kMotion;
  same.rotation.coeffs() *= -1;  // the same rotation by its other quaternion
  EXPECT_NEAR(squared_mahalanobis(same, prior), 0, 1e-9);
}

TEST(CompareViews, AgreeAtTheSamePose) {
  const RgbdPyramid view = view_of(box_room(), kStart);
  const ViewAgreement agreement = compare_views(view, view, RigidTransform::identity());
  EXPECT_GT(agreement.overlap, 0.95);
  EXPECT_EQ(agreement.agreeing, 1);
  EXPECT_EQ(agreement.seen_through, 0);
  EXPECT_EQ(agreement.in_front, 0);
}

TEST(CompareViews, AgreeAtTheTruePoseOnly) {
  const RgbdPyramid reference = view_of(box_room(), kStart);
  const RgbdPyramid current = view_of(box_room(), kStart * kMotion);
  EXPECT_GT(compare_views(reference, current, kMotion).agreeing, 0.99);
  const RigidTransform wrong = kMotion * motion_by({0, 0.15, 0}, {0.2, 0, 0.3});
  EXPECT_LT(compare_views(reference, current, wrong).agreeing, 0.6);
}

TEST(CompareViews, TellsWhatHidesFromWhatIsSeenThrough) {
  const auto at = [](double distance_m) {
    return view_of(wall(distance_m), RigidTransform::identity());
  };
  const ViewAgreement nearer = compare_views(at(2), at(1.5), RigidTransform::identity());
  EXPECT_EQ(nearer.in_front, 1);
  EXPECT_EQ(nearer.agreeing, 0);
  const ViewAgreement farther = compare_views(at(2), at(2.5), RigidTransform::identity());
  EXPECT_EQ(farther.seen_through, 1);
  EXPECT_EQ(farther.agreeing, 0);
  // The pose makes up for it.
  EXPECT_EQ(compare_views(at(2), at(1.5), motion_by({0, 0, 0}, {0, 0, 0.5})).agreeing, 1);
}

TEST(CompareViews, OverlapIsThePartThatBothSee) {
  const RgbdPyramid view = view_of(wall(2), RigidTransform::identity());
  // 160 px at a focal length of 134 px: 2.39 m of the wall are seen; a third of that to the side.
  const ViewAgreement aside = compare_views(view, view, motion_by({0, 0, 0}, {0.8, 0, 0}));
  EXPECT_NEAR(aside.overlap, 0.67, 0.03);
  EXPECT_EQ(aside.agreeing, 1);
  const ViewAgreement apart = compare_views(view, view, motion_by({0, 0, 0}, {3, 0, 0}));
  EXPECT_EQ(apart.overlap, 0);
  EXPECT_EQ(apart.agreeing, 0);
  const ViewAgreement behind = compare_views(view, view, motion_by({0, M_PI, 0}, {0, 0, 0}));
  EXPECT_EQ(behind.overlap, 0);
  EXPECT_EQ(compare_views(view, RgbdPyramid(), {}).overlap, 0);
  EXPECT_EQ(compare_views(RgbdPyramid(), view, {}).overlap, 0);
}

TEST(ViewAlignmentOptions, SaysWhichFieldIsWrong) {
  EXPECT_OK(ViewAlignmentOptions{}.validate());
  EXPECT_ERROR(ViewAlignmentOptions{.gray_sigma = 0}.validate(), "gray_sigma");
  EXPECT_ERROR(ViewAlignmentOptions{.depth_sigma_m = NAN}.validate(), "depth_sigma_m");
}

}  // namespace
}  // namespace roomwise::motion
