#pragma once

#include <ATen/core/Tensor.h>

#include "laboratory/training/processes.h"
#include "laboratory/training/trainable_graph.h"
#include "laboratory/training/trainer.h"
#include "roomwise/base/thread_pool.h"

namespace roomwise::training {

// Pictures by their values and their classes as tensors on a device. The values are not copied on
// the processor, so they must stay.
struct TensorBatch {
  at::Tensor pictures;  // count x 3 x height x width
  at::Tensor labels;    // count
};
[[nodiscard]] TensorBatch tensors_of(std::vector<float>& pictures,
                                     const std::vector<std::int64_t>& labels,
                                     const network::ModelCard& card, at::Device device);

// The mean cross-entropy of a batch, that of the second head added where there is one. outputs: the
// network's, count x classes each.
[[nodiscard]] at::Tensor loss_of(const Values& outputs, const at::Tensor& labels,
                                 const TrainingOptions& options);

struct HeldOutScore {
  double cross_entropy = 0;  // without label smoothing
  double precision = 0;
};
// How the network does on data that it does not learn from, its pictures shared out to all
// processes; NaN where there are none. Fails where a picture cannot be read.
[[nodiscard]] Expected<HeldOutScore> score_held_out(const TrainableGraph& graph,
                                                    const TrainingTask& task,
                                                    const TrainingOptions& options,
                                                    at::Device device, Processes& processes);

}  // namespace roomwise::training
