#include "roomwise/rooms/statistics/principal_components.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace roomwise::rooms {
namespace {

constexpr ComponentLimits kAll{.rows = 1000, .directions = 1000};

// Rows that lie at +-3 along (0.6, 0.8, 0), +-1 along (0.8, -0.6, 0) and +-0.5 upwards, about
// (10, 20, 30).
Eigen::MatrixXf box_corners() {
  const Eigen::RowVector3f a(0.6F, 0.8F, 0), b(0.8F, -0.6F, 0), c(0, 0, 1);
  Eigen::MatrixXf rows(8, 3);
  for (int i = 0; i < 8; ++i) {
    const auto sign = [i](int bit) { return (i >> bit & 1) != 0 ? 1.0F : -1.0F; };
    rows.row(i) =
        Eigen::RowVector3f(10, 20, 30) + 3 * sign(0) * a + sign(1) * b + 0.5F * sign(2) * c;
  }
  return rows;
}

TEST(PrincipalComponents, AreTheAxesOfABox) {
  const PrincipalComponents found = principal_components(box_corners(), kAll);
  EXPECT_TRUE(found.mean.isApprox(Eigen::Vector3f(10, 20, 30), 1e-5F));
  ASSERT_EQ(found.directions.cols(), 3);
  EXPECT_NEAR(std::abs(found.directions.col(0).dot(Eigen::Vector3f(0.6F, 0.8F, 0))), 1, 1e-5);
  EXPECT_NEAR(std::abs(found.directions.col(1).dot(Eigen::Vector3f(0.8F, -0.6F, 0))), 1, 1e-5);
  EXPECT_TRUE(found.deviations.isApprox(Eigen::Vector3f(3, 1, 0.5F), 1e-4F));
  EXPECT_EQ(found.remaining_variance, 0) << "no direction is left";
}

TEST(PrincipalComponents, WhatIsLeftIsTheMeanOfTheOtherDirections) {
  const PrincipalComponents found = principal_components(box_corners(), {1000, 1});
  ASSERT_EQ(found.directions.cols(), 1);
  EXPECT_NEAR(found.remaining_variance, (1 + 0.25) / 2, 1e-4);
}

TEST(PrincipalComponents, TakesNoMoreRowsThanItIsTold) {
  Eigen::MatrixXf rows(100, 2);
  for (int i = 0; i < 100; ++i) rows.row(i) << static_cast<float>(i), i % 2 == 0 ? 7 : -7;
  // Every second row: the second number is always 7.
  const PrincipalComponents found = principal_components(rows, {50, 2});
  ASSERT_EQ(found.directions.cols(), 1);
  EXPECT_EQ(found.mean, Eigen::Vector2f(49, 7));
}

TEST(PrincipalComponents, RowsThatAreAllAlikeHaveNone) {
  const PrincipalComponents found =
      principal_components(Eigen::MatrixXf::Constant(5, 3, 0.5F), kAll);
  EXPECT_EQ(found.directions.cols(), 0);
  EXPECT_EQ(found.remaining_variance, 0);
  EXPECT_THROW((void)principal_components(Eigen::MatrixXf(0, 3), kAll), std::invalid_argument);
  EXPECT_THROW((void)principal_components(box_corners(), {0, 3}), std::invalid_argument);
}

}  // namespace
}  // namespace roomwise::rooms
