#pragma once

#include <cmath>

namespace roomwise::geometry {

// What a squared residual s costs under a robust kernel, and the cost's derivatives by s.
struct RobustLoss {
  double value = 0;
  double derivative = 1;
  double second_derivative = 0;
};

// Cauchy's kernel, k log(1 + s / k).
[[nodiscard]] inline RobustLoss cauchy_loss(double squares, double kernel) {
  const double derivative = 1 / (1 + squares / kernel);
  return {kernel * std::log1p(squares / kernel), derivative, -derivative * derivative / kernel};
}

// Huber's kernel: square up to a residual of `limit`, linear beyond. Without a second derivative.
[[nodiscard]] inline RobustLoss huber_loss(double squares, double limit) {
  const double norm = std::sqrt(squares);
  if (norm <= limit) return {squares, 1};
  return {limit * (2 * norm - limit), limit / norm};
}

}  // namespace roomwise::geometry
