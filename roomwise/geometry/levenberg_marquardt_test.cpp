#include "roomwise/geometry/levenberg_marquardt.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

namespace roomwise::geometry {
namespace {

// Rosenbrock's valley: residuals 10 (y - x^2) and 1 - x.
struct Valley {
  Eigen::Vector2d at{-1.2, 1};
  Eigen::Matrix2d hessian;
  Eigen::Vector2d rhs, step, before;
  bool has_solution = true;
  int linearizations = 0, taken = 0, undone = 0;

  [[nodiscard]] Eigen::Vector2d residuals() const {
    return {10 * (at.y() - at.x() * at.x()), 1 - at.x()};
  }
  [[nodiscard]] double cost() const { return residuals().squaredNorm(); }
  void linearize() {
    ++linearizations;
    Eigen::Matrix2d jacobian;
    jacobian << -20 * at.x(), 10, -1, 0;
    hessian = jacobian.transpose() * jacobian;
    rhs = -jacobian.transpose() * residuals();
  }
  std::optional<DampedStep> solve(double damping) {
    if (!has_solution) return std::nullopt;
    const Eigen::Vector2d weights = damping * damping_weights(hessian.diagonal());
    Eigen::Matrix2d damped = hessian;
    damped.diagonal() += weights;
    step = damped.inverse() * rhs;
    return DampedStep{step.dot(rhs + weights.cwiseProduct(step)), step.norm()};
  }
  void take_step() {
    ++taken;
    before = at;
    at += step;
  }
  void undo_step() {
    ++undone;
    at = before;
  }
};

constexpr MinimizerOptions kThorough{.relative_tolerance = 1e-12, .min_step_length = 1e-12};

TEST(Minimize, FindsTheMinimumAndLinearizesOnlyWhereItMoved) {
  Valley valley;
  const MinimizerSummary summary = minimize(valley, kThorough);
  EXPECT_TRUE(summary.converged());
  EXPECT_LT((valley.at - Eigen::Vector2d(1, 1)).norm(), 1e-6);
  EXPECT_EQ(summary.final_cost, valley.cost());
  EXPECT_GT(summary.initial_cost, 20);
  EXPECT_GT(valley.undone, 0);
  EXPECT_EQ(valley.taken, summary.iterations);
  EXPECT_LE(valley.linearizations, 1 + valley.taken - valley.undone);
}

TEST(Minimize, SaysWhyItEnded) {
  Valley few;
  MinimizerOptions options = kThorough;
  options.max_iterations = 2;
  EXPECT_EQ(minimize(few, options).termination, Termination::kMaxIterations);

  Valley interrupted;
  int asked = 0;
  const auto summary = minimize(interrupted, kThorough, [&] { return ++asked <= 3; });
  EXPECT_EQ(summary.termination, Termination::kInterrupted);
  EXPECT_EQ(summary.iterations, 3);
  EXPECT_EQ(summary.final_cost, interrupted.cost());

  Valley singular;
  singular.has_solution = false;
  EXPECT_EQ(minimize(singular, kThorough).termination, Termination::kNoStepFound);
  EXPECT_EQ(singular.at, Valley().at);
}

TEST(DampingWeights, HoldWhatNothingIsKnownAbout) {
  EXPECT_EQ(damping_weights(Eigen::Vector3d(4, 0, 1)), Eigen::Vector3d(4, 4e-9, 1));
}

}  // namespace
}  // namespace roomwise::geometry
