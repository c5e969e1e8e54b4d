#include "laboratory/trials/logistic_regression.h"

#include <Eigen/Cholesky>

namespace roomwise::trials {

Eigen::VectorXd logistic_regression(const Eigen::MatrixXd& rows, const Eigen::VectorXd& is_true,
                                    const Eigen::VectorXd& sample_weights,
                                    const Eigen::VectorXd& penalty) {
  constexpr int kIterations = 50;
  constexpr double kEnough = 1e-8;
  constexpr double kMinCurvature = 1e-6;
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(rows.cols());
  for (int i = 0; i < kIterations; ++i) {
    const Eigen::VectorXd probability = (1 + (-(rows * weights)).array().exp()).inverse();
    const Eigen::VectorXd gradient =
        rows.transpose() * sample_weights.cwiseProduct(probability - is_true) +
        penalty.cwiseProduct(weights);
    const Eigen::VectorXd curvature =
        sample_weights.array() *
        (probability.array() * (1 - probability.array())).max(kMinCurvature);
    Eigen::MatrixXd hessian = rows.transpose() * curvature.asDiagonal() * rows;
    hessian.diagonal() += penalty;
    const Eigen::VectorXd step = hessian.ldlt().solve(gradient);
    weights -= step;
    if (step.cwiseAbs().maxCoeff() < kEnough) break;
  }
  return weights;
}

}  // namespace roomwise::trials
