#include "roomwise/rooms/statistics/minimizer.h"

#include <gmock/gmock.h>

#include <cmath>

namespace roomwise::rooms {
namespace {

TEST(Lbfgs, FindsTheMinimumOfALongValley) {
  // x^2 / 2 + 500 y^2 + z^4 / 4, moved to (1, -2, 3).
  const Eigen::Vector3d minimum(1, -2, 3);
  Lbfgs minimizer(Eigen::Vector3d(9, 9, 9), 1e-9);
  int evaluations = 0;
  while (!minimizer.done() && evaluations < 500) {
    const Eigen::Vector3d d = minimizer.place() - minimum;
    minimizer.tell(d.x() * d.x() / 2 + 500 * d.y() * d.y() + std::pow(d.z(), 4) / 4,
                   Eigen::Vector3d(d.x(), 1000 * d.y(), std::pow(d.z(), 3)));
    ++evaluations;
  }
  EXPECT_TRUE(minimizer.done());
  EXPECT_LT(evaluations, 150);
  EXPECT_NEAR(minimizer.lowest().x(), 1, 1e-8);
  EXPECT_NEAR(minimizer.lowest().y(), -2, 1e-11);
  EXPECT_NEAR(minimizer.lowest().z(), 3, 2e-3);  // a fourth power is flat
}

// Evaluations until x^2 / 2 + 500 y^2 + 50000 z^2 is at its minimum, from (9, 9, 9).
int evaluations_of_a_long_valley(const Lbfgs::Product& inverse_curvature) {
  const Eigen::Vector3d curvatures(1, 1000, 100000);
  Lbfgs minimizer(Eigen::Vector3d(9, 9, 9), 1e-9, inverse_curvature);
  int evaluations = 0;
  while (!minimizer.done() && evaluations < 500) {
    const Eigen::Vector3d gradient = minimizer.place().cwiseProduct(curvatures);
    minimizer.tell(minimizer.place().dot(gradient) / 2, gradient);
    ++evaluations;
  }
  EXPECT_LT(minimizer.lowest().norm(), 1e-8);
  return evaluations;
}

TEST(Lbfgs, IsThereAtOnceWhereTheCurvatureIsKnown) {
  const auto known = [](const Eigen::VectorXd& gradient) -> Eigen::VectorXd {
    return gradient.cwiseQuotient(Eigen::Vector3d(1, 1000, 100000));
  };
  const auto nearly = [](const Eigen::VectorXd& gradient) -> Eigen::VectorXd {
    return gradient.cwiseQuotient(Eigen::Vector3d(3, 500, 300000));
  };
  EXPECT_EQ(evaluations_of_a_long_valley(known), 2) << "at the start and at the end";
  EXPECT_LT(evaluations_of_a_long_valley(nearly), 15);
  EXPECT_GT(evaluations_of_a_long_valley({}), 15);
}

TEST(Lbfgs, IsThereInTheEndByAWrongGuessToo) {
  const auto far_too_long = [](const Eigen::VectorXd& gradient) -> Eigen::VectorXd {
    return 1e12 * gradient;
  };
  const auto uphill = [](const Eigen::VectorXd& gradient) -> Eigen::VectorXd { return -gradient; };
  const auto no_number = [](const Eigen::VectorXd& gradient) -> Eigen::VectorXd {
    return std::nan("") * gradient;
  };
  EXPECT_LT(evaluations_of_a_long_valley(far_too_long), 200);
  EXPECT_LT(evaluations_of_a_long_valley(uphill), 200);
  EXPECT_LT(evaluations_of_a_long_valley(no_number), 200);
}

TEST(Lbfgs, IsDoneAtOnceAtTheMinimum) {
  Lbfgs minimizer(Eigen::Vector2d(4, 5), 1e-6);
  minimizer.tell(7, Eigen::Vector2d::Zero());
  EXPECT_TRUE(minimizer.done());
  EXPECT_EQ(minimizer.lowest(), Eigen::Vector2d(4, 5));
}

TEST(Lbfgs, StopsWhereNoStepLeadsDown) {
  // |x| with the slope of one side: nothing is lower than 0, and the gradient never vanishes.
  Lbfgs minimizer(Eigen::VectorXd::Zero(1), 1e-6);
  for (int i = 0; i < 100 && !minimizer.done(); ++i) {
    const Eigen::VectorXd x = minimizer.place();
    minimizer.tell(std::abs(x[0]), Eigen::VectorXd::Constant(1, x[0] < 0 ? -1.0 : 1.0));
  }
  EXPECT_TRUE(minimizer.done());
  EXPECT_EQ(minimizer.lowest()[0], 0);
}

}  // namespace
}  // namespace roomwise::rooms
