#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "laboratory/training/training_data.h"
#include "laboratory/training/training_options.h"
#include "roomwise/base/progress.h"
#include "roomwise/network/formats/model_card.h"
#include "roomwise/network/graph/onnx_graph.h"

namespace roomwise::training {

class Processes;

// What is trained, on what.
struct TrainingTask {
  network::OnnxGraph graph;
  network::ModelCard card;  // how pictures are put in
  std::string logits;       // the value that has a score a class, before softmax
  std::string aux_logits;   // that of a second head, which helps to train; empty: there is none
  const TrainingData* training = nullptr;
  const TrainingData* held_out = nullptr;  // may be empty: then the last step counts as the best
};

// How far a training was after so many steps.
struct CurvePoint {
  std::int64_t step = 0;
  double cross_entropy = 0;  // mean over the steps since the point before, as they were trained
  // Of the held-out pictures; NaN where there are none.
  double held_out_cross_entropy = 0;
  double held_out_precision = 0;  // the share whose highest score is that of their class

  friend bool operator==(const CurvePoint&, const CurvePoint&) = default;
};

struct TrainingResult {
  network::OnnxGraph graph;  // with the weights of the best step
  std::vector<CurvePoint> curve;
  // Where the held-out precision was highest; of several such steps, where the cross-entropy was
  // lowest.
  std::int64_t best_step = 0;
  std::int64_t steps = 0;  // that were made, those before a resumption too
  bool finished = false;   // false: interrupted before the last step
};

// Fine-tunes a network with cross-entropy by steepest descent on batches. Interrupted through
// `progress`, it writes its checkpoint and ends; a training that is resumed from a checkpoint,
// after that or after a kill, gives the bits of one that was never stopped, as long as the number
// of threads and the processor are the same.
//
// Several processes share each step's pictures out; gradients and the running statistics of batch
// normalisation are averaged, so that all keep the same weights. Batch statistics are those of each
// process's own pictures. Rank 0 writes (and, to resume, reads) the checkpoint.
//
// Fails where options are invalid, where a picture cannot be read, where the network does not fit
// its data, where the checkpoint cannot be written or is of another training, and where the loss is
// no longer finite.
[[nodiscard]] Expected<TrainingResult> train(const TrainingTask& task,
                                             const TrainingOptions& options, Processes& processes,
                                             Progress& progress);

// libtorch takes large tensors from the system anew each time and gives them back; keeping them
// spares up to a third of a training's processor time. For programs that do nothing else, before
// their work.
void keep_memory_of_large_tensors();

// Threads of libtorch, and of the BLAS that it uses where that has threads of its own.
void set_threads(int count);

// On what tensors are computed, for `device`. Fails where a GPU is asked for and there is none.
[[nodiscard]] Expected<bool> use_gpu(Device device);

}  // namespace roomwise::training
