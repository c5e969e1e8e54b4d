#include "laboratory/trials/variance_regression.h"

namespace roomwise::trials {

// A Student's t is a normal error whose precision varies. Expectation-maximisation finds what each
// row's precision is; given that, the weights' multiplicative step raises the likelihood and keeps
// them positive (Févotte, Bertin and Durrieu 2009, for the Itakura-Saito divergence).
Eigen::VectorXd variance_regression(const Eigen::MatrixXd& terms, const Eigen::VectorXd& errors,
                                    const Eigen::VectorXd& sample_weights,
                                    double degrees_of_freedom) {
  constexpr int kIterations = 5000;
  constexpr double kTiny = 1e-12, kEnough = 1e-9;
  const Eigen::ArrayXd squares = errors.array().square();
  const Eigen::ArrayXd rows = sample_weights.array();
  const auto terms_count = static_cast<double>(terms.cols());
  Eigen::VectorXd weights =
      ((rows * squares).sum() / rows.sum() / terms_count) *
      (terms.transpose() * sample_weights / rows.sum()).cwiseMax(kTiny).cwiseInverse();
  for (int i = 0; i < kIterations; ++i) {
    const Eigen::ArrayXd scale = (terms * weights).array().max(kTiny);  // squared
    const Eigen::ArrayXd precision =
        (degrees_of_freedom + 1) / (degrees_of_freedom + squares / scale);
    const Eigen::VectorXd more =
        terms.transpose() * (rows * precision * squares / scale.square()).matrix();
    const Eigen::VectorXd less = terms.transpose() * (rows / scale).matrix();
    const Eigen::VectorXd next = weights.array() * (more.array() / less.array().max(kTiny)).sqrt();
    const bool is_enough = (next - weights).cwiseAbs().maxCoeff() < kEnough * weights.maxCoeff();
    weights = next;
    if (is_enough) break;
  }
  return weights * (degrees_of_freedom / (degrees_of_freedom - 2));
}

}  // namespace roomwise::trials
