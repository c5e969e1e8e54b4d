#include "laboratory/trials/variance_regression.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace roomwise::trials {
namespace {

constexpr double kFreedom = 4;

// Errors whose variance is 0.01 + 0.25 of the second term, and none of the third.
struct Errors {
  Eigen::MatrixXd terms{2000, 3};
  Eigen::VectorXd errors{2000};
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(2000);
};
Errors made_up() {
  Errors made;
  std::mt19937 random(7);
  std::student_t_distribution<double> error(kFreedom);
  std::uniform_real_distribution<double> term(0, 1);
  for (int i = 0; i < 2000; ++i) {
    made.terms.row(i) << 1, term(random), term(random);
    const double variance = 0.01 + 0.25 * made.terms(i, 1);
    made.errors[i] = error(random) * std::sqrt(variance * (kFreedom - 2) / kFreedom);
  }
  return made;
}

TEST(VarianceRegression, FindsOfWhatTheVarianceIsMade) {
  const Errors made = made_up();
  const Eigen::VectorXd found =
      variance_regression(made.terms, made.errors, made.weights, kFreedom);
  EXPECT_NEAR(found[0], 0.01, 0.008);
  EXPECT_NEAR(found[1], 0.25, 0.04);
  EXPECT_NEAR(found[2], 0, 0.02);
  EXPECT_GE(found.minCoeff(), 0);
}

TEST(VarianceRegression, AFewThatAreFarOffWeighLittle) {
  Errors made = made_up();
  for (int i = 0; i < 20; ++i) made.errors[100 * i] = 50;
  const Eigen::VectorXd found =
      variance_regression(made.terms, made.errors, made.weights, kFreedom);
  EXPECT_LT(found[0] + found[1], 0.4) << "a normal error would make it 25";
}

TEST(VarianceRegression, RowsWithoutWeightDoNotCount) {
  Errors made = made_up();
  made.errors.tail(1000) *= 10;
  made.weights.tail(1000).setConstant(1e-9);
  const Eigen::VectorXd found =
      variance_regression(made.terms, made.errors, made.weights, kFreedom);
  EXPECT_NEAR(found[1], 0.25, 0.06);
}

}  // namespace
}  // namespace roomwise::trials
