#include "roomwise/motion/focal_length_fit.h"

#include <gtest/gtest.h>

#include <cmath>

namespace roomwise::motion {
namespace {

using geometry::PinholeCamera;
using geometry::RigidTransform;

PinholeCamera a_camera(double focal_px) {
  return {focal_px, focal_px, 319.5, 239.5, 640, 480, {}, 1000};
}

// A camera of 500 px as one who takes its focal length for `named_px` would measure its walk: it
// turns by up to `turn_rad` between two views and moves, some matches are wrong.
std::vector<MatchedViews> walk(double named_px, double turn_rad, int count = 60) {
  const PinholeCamera camera = a_camera(500), named = a_camera(named_px);
  RandomStream random(7);
  std::vector<MatchedViews> views;
  for (int i = 0; i < count; ++i) {
    geometry::Vector6d twist;
    twist << random.between(-turn_rad, turn_rad), random.between(-turn_rad, turn_rad),
        random.between(-turn_rad, turn_rad), random.between(-0.1, 0.1), random.between(-0.1, 0.1),
        random.between(-0.1, 0.1);
    const RigidTransform reference_from_current = RigidTransform::exp(twist);
    MatchedViews& seen = views.emplace_back(MatchedViews{{}, reference_from_current});
    while (seen.observations.size() < 60) {
      const Eigen::Vector2d pixel(640 * random.uniform(), 480 * random.uniform());
      const double depth_m = random.between(1, 4);
      const Eigen::Vector3d point =
          reference_from_current.inverse() * camera.unproject(pixel, depth_m);
      if (point.z() < 0.5) continue;
      const Eigen::Vector2d noise = 0.5 * Eigen::Vector2d(random.normal(), random.normal());
      const bool is_wrong = seen.observations.size() % 6 == 0;
      seen.observations.push_back({named.unproject(pixel, depth_m),
                                   is_wrong ? pixel : camera.project(point) + noise, point.z()});
    }
  }
  return views;
}

TEST(FocalLengthFit, FindsTheOneThatThePicturesFit) {
  for (const double named_px : {400.0, 450.0, 500.0, 550.0, 600.0}) {
    const auto fit = fit_focal_length(walk(named_px, 0.3), a_camera(named_px));
    ASSERT_TRUE(fit) << named_px;
    EXPECT_NEAR(fit->ratio, 500 / named_px, 0.01) << named_px;
    EXPECT_LT(fit->low(), fit->ratio);
    EXPECT_GT(fit->high(), fit->ratio);
    EXPECT_EQ(fit->contradicts(), named_px != 500) << named_px;
  }
}

TEST(FocalLengthFit, SmallErrorsAreNoContradiction) {
  const auto fit = fit_focal_length(walk(490, 0.3), a_camera(490));
  ASSERT_TRUE(fit);
  EXPECT_FALSE(fit->contradicts());
}

// Depth alone cannot tell: what is seen and what is measured narrow alike.
TEST(FocalLengthFit, ACameraThatDoesNotTurnTellsNothing) {
  for (const double named_px : {400.0, 500.0, 600.0}) {
    EXPECT_FALSE(fit_focal_length(walk(named_px, 0), a_camera(named_px))) << named_px;
  }
  EXPECT_TRUE(fit_focal_length(walk(400, 0.02), a_camera(400))) << "one that hardly turns does";
}

TEST(FocalLengthFit, SaysNothingOfAFewViews) {
  EXPECT_FALSE(fit_focal_length(walk(400, 0.3, 29), a_camera(400)));
  EXPECT_FALSE(fit_focal_length({}, a_camera(400)));
  EXPECT_FALSE(fit_focal_length(std::vector<MatchedViews>(60), a_camera(400)));
}

}  // namespace
}  // namespace roomwise::motion
