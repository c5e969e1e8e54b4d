#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "roomwise/base/expected.h"
#include "roomwise/network/vision/augmentation.h"

namespace roomwise::training {

// How large the steps are, over the course of a training.
struct LearningRate {
  enum class Schedule {
    kConstant,
    kSteps,   // times `decay` every `decay_every` steps
    kCosine,  // down to 0 at the last step along half a cosine (Loshchilov and Hutter 2017)
  };
  double base = 0.01;
  Schedule schedule = Schedule::kCosine;
  std::int64_t decay_every = 1000;  // of kSteps
  double decay = 0.5;               // of kSteps
  std::int64_t warm_up_steps = 0;   // of the first steps: rises evenly to what it would be

  // At step `step` of `steps`, counted from 0.
  [[nodiscard]] double at(std::int64_t step, std::int64_t steps) const;
};

enum class Optimizer {
  kSgd,      // with momentum
  kRmsProp,  // with momentum
  kAdam,     // its first moment is the momentum
};

enum class Device { kAuto, kCpu, kCuda };

struct TrainingOptions {
  std::int64_t steps = 1000;
  std::int64_t batch = 16;  // pictures a step, of each process
  LearningRate rate;
  Optimizer optimizer = Optimizer::kSgd;
  double momentum = 0.9;
  double weight_decay = 4e-5;    // of weights, not of biases and batch norms
  double label_smoothing = 0.1;  // of the certainty this share is spread over all classes
  double aux_weight = 0.4;       // of the loss of a second head, where there is one
  std::string from;              // TrainableGraphOptions::from
  network::AugmentationOptions augmentation = network::kNoAugmentation;
  std::int64_t evaluate_every = 100;    // steps; and after the last
  std::int64_t checkpoint_every = 100;  // steps
  std::filesystem::path checkpoint;     // where; empty: nowhere
  bool resume = false;                  // goes on from the checkpoint, which must be there
  std::uint64_t seed = 0;
  // The last bits of a training depend on their number, since libtorch shares sums out to them.
  int threads = 1;
  std::size_t loader_threads = 1;  // that make pictures ready ahead; no bit depends on them
  Device device = Device::kAuto;

  // Fails, naming the option and what it may be.
  [[nodiscard]] Expected<void> validate() const;
  // All that results hang on, a line each: what a checkpoint must have been made with.
  [[nodiscard]] std::string fingerprint() const;
};

}  // namespace roomwise::training
