#pragma once

#include <span>
#include <vector>

#include "roomwise/rooms/statistics/minimizer.h"
#include "roomwise/rooms/statistics/principal_components.h"
#include "roomwise/rooms/statistics/sample_products.h"
#include "roomwise/rooms/statistics/softmax_regression.h"

namespace roomwise::rooms {

// Trains several regressions at once on parts of the same samples: one pass over the samples serves
// all of them.
class SoftmaxTrainer {
 public:
  // samples: one a row; labels[i] in [0, classes). `pool` may be absent.
  [[nodiscard]] static Expected<SoftmaxTrainer> create(const Eigen::MatrixXf& samples,
                                                       std::span<const int> labels, int classes,
                                                       ThreadPool* pool = nullptr);

  // One regression for each entry of `parts`, which says of every sample whether it is learned from
  // (SoftmaxRegression::train on those samples). `starts`: what to begin from, one for each part,
  // or none; the minimum is the same from any start. Fails where a part lacks a class.
  [[nodiscard]] Expected<std::vector<SoftmaxRegression>> train(
      std::span<const std::vector<bool>> parts, const SoftmaxOptions& options,
      std::span<const SoftmaxRegression> starts = {}) const;

 private:
  class Losses;
  SoftmaxTrainer(SampleBlocks blocks, Eigen::RowVectorXf mean, PrincipalComponents components,
                 std::vector<int> labels, int classes, ThreadPool* pool)
      : blocks_(std::move(blocks)),
        mean_(std::move(mean)),
        components_(std::move(components)),
        labels_(std::move(labels)),
        classes_(classes),
        pool_(pool) {}
  // About what multiplies a gradient to lead to the minimum at once; as long as the trainer lives.
  [[nodiscard]] Lbfgs::Product inverse_curvature(double weight_decay) const;
  [[nodiscard]] Eigen::VectorXd parameters_of(const SoftmaxRegression& regression) const;
  [[nodiscard]] SoftmaxRegression regression_of(const Eigen::VectorXd& parameters) const;

  SampleBlocks blocks_;  // less their mean
  Eigen::RowVectorXf mean_;
  PrincipalComponents components_;  // of some samples
  std::vector<int> labels_;
  int classes_;
  ThreadPool* pool_;
};

}  // namespace roomwise::rooms
