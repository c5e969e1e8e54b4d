#include "roomwise/rooms/statistics/softmax_regression.h"

#include <cmath>

#include "roomwise/rooms/statistics/softmax_trainer.h"

namespace roomwise::rooms {

Expected<void> SoftmaxOptions::validate() const {
  if (!(weight_decay >= 0 && std::isfinite(weight_decay))) {
    return fail("weight_decay is {}; expected 0 or more", weight_decay);
  }
  if (max_iterations < 1) return fail("max_iterations is {}; expected 1 or more", max_iterations);
  if (!(gradient_tolerance > 0 && std::isfinite(gradient_tolerance))) {
    return fail("gradient_tolerance is {}; expected more than 0", gradient_tolerance);
  }
  return {};
}

Expected<SoftmaxRegression> SoftmaxRegression::train(const Eigen::MatrixXf& samples,
                                                     std::span<const int> labels, int classes,
                                                     const SoftmaxOptions& options,
                                                     ThreadPool* pool) {
  ROOMWISE_CHECK_OK(options.validate());
  ROOMWISE_TRY(const auto trainer, SoftmaxTrainer::create(samples, labels, classes, pool));
  const std::vector<bool> all(labels.size(), true);
  ROOMWISE_TRY(auto trained, trainer.train(std::span(&all, 1), options));
  return std::move(trained.front());
}

Eigen::VectorXf SoftmaxRegression::probabilities(const Eigen::VectorXf& sample) const {
  const Eigen::VectorXd logits = (weights_ * sample + biases_).cast<double>();
  const Eigen::VectorXd powers = (logits.array() - logits.maxCoeff()).exp();
  return (powers / powers.sum()).cast<float>();
}

}  // namespace roomwise::rooms
