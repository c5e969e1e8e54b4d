// Eigen adds in the same order on every processor, so that it gives the same bits on each: on arm64
// by cmake/eigen_as_on_x86.h and cmake/eigen_products_as_on_x86.h.
#include <gtest/gtest.h>

#include <Eigen/Core>

namespace roomwise::geometry {
namespace {

// One is lost where it meets the large number before that has gone.
constexpr float kLarge = 1e9F;
constexpr double kLargeDouble = 1e18;

TEST(OrderOfSumsTest, ThreeFloatsAreAddedFromTheEnd) {
  const Eigen::Vector3f terms(1, kLarge, -kLarge);
  EXPECT_EQ(terms.dot(Eigen::Vector3f::Ones()), 1);
  EXPECT_EQ(terms.sum(), 1);
  Eigen::Matrix3f rows;
  rows << terms, terms, terms;
  const Eigen::Matrix3f turned = rows.transpose();
  EXPECT_EQ(turned * Eigen::Vector3f::Ones(), Eigen::Vector3f::Ones());
}

TEST(OrderOfSumsTest, ALargeProductTakesRowsByFoursAndTheLastTwoByEvenAndOddTerms) {
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(6, 8);
  rows.col(0).setOnes();
  rows.col(1).setConstant(kLargeDouble);
  rows.col(3).setConstant(-kLargeDouble);
  const Eigen::MatrixXd product = rows * Eigen::MatrixXd::Ones(8, 8);
  const Eigen::MatrixXd first = product.topRows(4), last = product.bottomRows(2);
  EXPECT_EQ(first, Eigen::MatrixXd::Zero(4, 8));
  EXPECT_EQ(last, Eigen::MatrixXd::Ones(2, 8));
}

}  // namespace
}  // namespace roomwise::geometry
