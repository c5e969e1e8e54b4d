#pragma once

#include <deque>
#include <future>
#include <vector>

#include "laboratory/training/training_data.h"
#include "roomwise/base/thread_pool.h"
#include "roomwise/network/formats/model_card.h"
#include "roomwise/network/vision/augmentation.h"

namespace roomwise::training {

// Pictures as a network takes them, one after the other, and their classes.
struct Batch {
  std::vector<float> pictures;  // count x 3 x height x width
  std::vector<std::int64_t> labels;
};

// Which picture is the n-th that a training sees: all pictures once an epoch, each epoch in an
// order of its own, which depends on the seed and the epoch alone.
class SampleOrder {
 public:
  SampleOrder(std::size_t size, std::uint64_t seed) : size_(size), seed_(seed) {}

  struct Sample {
    std::uint64_t epoch = 0;
    std::size_t picture = 0;
  };
  [[nodiscard]] Sample sample(std::uint64_t n);

 private:
  std::size_t size_;
  std::uint64_t seed_;
  std::uint64_t epoch_ = 0;  // of `order_`, where that is not empty
  std::vector<std::size_t> order_;
};

struct BatchLoaderOptions {
  std::int64_t batch = 16;
  // This process's part of the batches of all of them.
  std::int64_t rank = 0;
  std::int64_t processes = 1;
  std::uint64_t seed = 0;
  network::AugmentationOptions augmentation;
  std::size_t threads = 1;
  std::size_t ahead = 2;  // batches that are made ready beforehand
};

// Makes the batches of a training ready ahead, on threads of its own. A batch depends on its step
// and the seed alone; a picture is varied by a stream of its own, keyed by epoch and picture.
class BatchLoader {
 public:
  // The data must have a picture and outlive the loader.
  BatchLoader(const TrainingData& data, const network::ModelCard& card,
              const BatchLoaderOptions& options, std::int64_t first_step);

  // The batch of the next step. Fails where a picture cannot be read.
  [[nodiscard]] Expected<Batch> next();

 private:
  using Picture = Expected<std::vector<float>>;
  struct Pending {
    std::vector<std::future<Picture>> pictures;
    std::vector<std::int64_t> labels;
  };
  void begin_batch();

  const TrainingData& data_;
  network::ModelCard card_;
  BatchLoaderOptions options_;
  SampleOrder order_;
  std::int64_t step_;  // of the next batch to begin
  std::deque<Pending> pending_;
  ThreadPool pool_;  // last, so that its tasks end before what they use goes
};

}  // namespace roomwise::training
