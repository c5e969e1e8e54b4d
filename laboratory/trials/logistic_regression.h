#pragma once

#include <Eigen/Core>

namespace roomwise::trials {

// The weights of a logistic regression with a ridge penalty of its own for each column, by Newton's
// method: rows * result are the log odds of what is_true (0 or 1) says. sample_weights: of each
// row.
[[nodiscard]] Eigen::VectorXd logistic_regression(const Eigen::MatrixXd& rows,
                                                  const Eigen::VectorXd& is_true,
                                                  const Eigen::VectorXd& sample_weights,
                                                  const Eigen::VectorXd& penalty);

}  // namespace roomwise::trials
