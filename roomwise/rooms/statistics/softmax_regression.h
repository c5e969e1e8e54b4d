#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "roomwise/base/expected.h"

namespace roomwise::rooms {

struct SoftmaxOptions {
  double weight_decay = 1e-3;        // factor of |W|^2 / 2 in the loss
  int max_evaluations = 300;         // of the loss and its gradient
  double gradient_tolerance = 1e-5;  // stops when the largest element of the gradient is below

  [[nodiscard]] Expected<void> validate() const;
};

// Multinomial logistic regression: p(class | x) = softmax(W x + b).
class SoftmaxRegression {
 public:
  static constexpr int kHeldOut = -1;  // as a label: the sample is not learned from

  SoftmaxRegression() = default;
  // weights: classes x features; biases: classes.
  SoftmaxRegression(Eigen::MatrixXf weights, Eigen::VectorXf biases)
      : weights_(std::move(weights)), biases_(std::move(biases)) {}

  // Minimises the mean cross-entropy plus weight decay by L-BFGS (Liu and Nocedal, 1989); classes
  // weigh the same however many samples each has. samples: one a row; labels[i] in [0, classes), or
  // kHeldOut. Deterministic. Fails where a class has no sample, or samples are not finite.
  [[nodiscard]] static Expected<SoftmaxRegression> train(const Eigen::MatrixXf& samples,
                                                         std::span<const int> labels, int classes,
                                                         const SoftmaxOptions& options);
  // One regression for each of the weight decays, in their order; each begins where the one before
  // ended, which saves evaluations if they are sorted. That of the options does not count.
  [[nodiscard]] static Expected<std::vector<SoftmaxRegression>> train_path(
      const Eigen::MatrixXf& samples, std::span<const int> labels, int classes,
      std::span<const double> weight_decays, const SoftmaxOptions& options);

  [[nodiscard]] Eigen::VectorXf probabilities(const Eigen::VectorXf& sample) const;
  [[nodiscard]] const Eigen::MatrixXf& weights() const { return weights_; }
  [[nodiscard]] const Eigen::VectorXf& biases() const { return biases_; }

 private:
  Eigen::MatrixXf weights_;
  Eigen::VectorXf biases_;
};

}  // namespace roomwise::rooms
