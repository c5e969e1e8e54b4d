#pragma once

#include <Eigen/Core>

namespace roomwise::trials {

// What variance errors have, as a sum of terms with weights that are not negative, by maximum
// likelihood: each error is taken for a Student's t of so many degrees of freedom (more than 2), so
// that a few outliers weigh little, with the variance terms.row(i) * result. Terms are not
// negative, and one of each row positive. Errors in m, terms in m²; sample_weights: of each row.
[[nodiscard]] Eigen::VectorXd variance_regression(const Eigen::MatrixXd& terms,
                                                  const Eigen::VectorXd& errors,
                                                  const Eigen::VectorXd& sample_weights,
                                                  double degrees_of_freedom);

}  // namespace roomwise::trials
