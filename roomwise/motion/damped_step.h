#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <optional>

#include "roomwise/geometry/levenberg_marquardt.h"

namespace roomwise::motion {

// Solves the damped normal equations of few variables (geometry::minimize) into `step`; nothing
// where there is no solution in double precision.
template <int kVariables>
[[nodiscard]] std::optional<geometry::DampedStep> solve_damped(
    const Eigen::Matrix<double, kVariables, kVariables>& hessian,
    const Eigen::Matrix<double, kVariables, 1>& rhs, double damping,
    Eigen::Matrix<double, kVariables, 1>& step) {
  const Eigen::Matrix<double, kVariables, 1> weights =
      damping * geometry::damping_weights(hessian.diagonal());
  Eigen::Matrix<double, kVariables, kVariables> damped = hessian;
  damped.diagonal() += weights;
  step = damped.ldlt().solve(rhs);
  if (!step.allFinite()) return std::nullopt;
  return geometry::DampedStep{rhs.dot(step) + step.dot(weights.cwiseProduct(step)), step.norm()};
}

}  // namespace roomwise::motion
