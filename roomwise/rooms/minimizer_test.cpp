#include "roomwise/rooms/minimizer.h"

#include <gmock/gmock.h>

#include <cmath>

namespace roomwise::rooms {
namespace {

TEST(Minimizer, FindsTheMinimumOfALongValley) {
  // x^2 / 2 + 500 y^2 + z^4 / 4, moved to (1, -2, 3).
  const Eigen::Vector3d minimum(1, -2, 3);
  Minimizer minimizer(Eigen::Vector3d(9, 9, 9), 1e-9);
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

TEST(Minimizer, IsDoneAtOnceAtTheMinimum) {
  Minimizer minimizer(Eigen::Vector2d(4, 5), 1e-6);
  minimizer.tell(7, Eigen::Vector2d::Zero());
  EXPECT_TRUE(minimizer.done());
  EXPECT_EQ(minimizer.lowest(), Eigen::Vector2d(4, 5));
}

TEST(Minimizer, StopsWhereNoStepLeadsDown) {
  // |x| with the slope of one side: nothing is lower than 0, and the gradient never vanishes.
  Minimizer minimizer(Eigen::VectorXd::Zero(1), 1e-6);
  for (int i = 0; i < 100 && !minimizer.done(); ++i) {
    const Eigen::VectorXd x = minimizer.place();
    minimizer.tell(std::abs(x[0]), Eigen::VectorXd::Constant(1, x[0] < 0 ? -1.0 : 1.0));
  }
  EXPECT_TRUE(minimizer.done());
  EXPECT_EQ(minimizer.lowest()[0], 0);
}

}  // namespace
}  // namespace roomwise::rooms
