#pragma once

#include <ATen/core/Tensor.h>

#include <torch/optim/optimizer.h>
#include <memory>
#include <optional>

#include "laboratory/training/trainable_graph.h"
#include "laboratory/training/trainer.h"
#include "roomwise/base/file.h"

namespace roomwise::training {

// All that changes while a network is trained. Random numbers are keyed by step, epoch and picture
// and so need no place here.
struct TrainingState {
  // The network's, which share their memory with it.
  std::vector<at::Tensor> tensors;
  std::unique_ptr<torch::optim::Optimizer> optimizer;
  std::int64_t step = 0;  // that were made
  double loss_sum = 0;    // since the last point of the curve
  std::vector<CurvePoint> curve;
  std::optional<CurvePoint> best;
  std::vector<at::Tensor> best_tensors;

  // fingerprint: what the training is; see TrainingOptions::fingerprint().
  [[nodiscard]] Expected<Bytes> write(const std::string& fingerprint) const;
  // Into the state of a training that has just begun. Fails where the bytes are of another
  // training, naming the first line that differs, or damaged.
  [[nodiscard]] Expected<void> read(const Bytes& bytes, const std::string& fingerprint);
};

// The first line that two such descriptions do not share: "BEFORE", not "NOW".
[[nodiscard]] std::string first_difference(std::string_view before, std::string_view now);

// The state at the beginning of training this network.
[[nodiscard]] TrainingState begin_training(const TrainableGraph& graph,
                                           const TrainingOptions& options);
// One step by the gradients that are there.
void descend(TrainingState& state, double learning_rate);

}  // namespace roomwise::training
