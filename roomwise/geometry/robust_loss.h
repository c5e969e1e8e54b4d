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

}  // namespace roomwise::geometry
