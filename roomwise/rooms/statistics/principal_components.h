#pragma once

#include <Eigen/Core>

namespace roomwise::rooms {

// The directions along which rows of numbers differ most from their mean.
struct PrincipalComponents {
  Eigen::VectorXf mean;
  Eigen::MatrixXf directions;     // columns of length 1, those of the largest variance first
  Eigen::VectorXf deviations;     // along each direction, the root of the variance
  double remaining_variance = 0;  // along each direction at right angles to them, in the mean
};

struct ComponentLimits {
  Eigen::Index rows = 1;        // at least 1; more are thinned out evenly
  Eigen::Index directions = 1;  // the most that are given
};

// Of at least one row. Directions of next to no variance, as rounding leaves them, are not given.
// Deterministic. Throws std::invalid_argument where there is no row, or none is allowed.
[[nodiscard]] PrincipalComponents principal_components(const Eigen::MatrixXf& rows,
                                                       const ComponentLimits& limits);

}  // namespace roomwise::rooms
