#include "laboratory/training/training_options.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace roomwise::training {

double LearningRate::at(std::int64_t step, std::int64_t steps) const {
  double rate = base;
  if (schedule == Schedule::kSteps)
    rate *= std::pow(decay, static_cast<double>(step / decay_every));
  if (schedule == Schedule::kCosine) {
    const double share = static_cast<double>(step) / static_cast<double>(steps);
    rate *= (1 + std::cos(std::numbers::pi * share)) / 2;
  }
  if (step < warm_up_steps)
    rate *= static_cast<double>(step + 1) / static_cast<double>(warm_up_steps);
  return rate;
}

Expected<void> TrainingOptions::validate() const {
  const auto at_least = [](std::int64_t value, std::int64_t least,
                           const char* name) -> Expected<void> {
    if (value >= least) return {};
    return fail("{} is {}; expected at least {}", name, value, least);
  };
  const auto between = [](double value, double low, double high,
                          const char* name) -> Expected<void> {
    if (value >= low && value <= high) return {};
    return fail("{} is {}; expected a number from {} to {}", name, value, low, high);
  };
  ROOMWISE_RETURN_IF_ERROR(at_least(steps, 1, "steps"));
  ROOMWISE_RETURN_IF_ERROR(at_least(batch, 1, "batch"));
  ROOMWISE_RETURN_IF_ERROR(at_least(rate.decay_every, 1, "decay_every"));
  ROOMWISE_RETURN_IF_ERROR(at_least(rate.warm_up_steps, 0, "warm_up_steps"));
  ROOMWISE_RETURN_IF_ERROR(at_least(evaluate_every, 1, "evaluate_every"));
  ROOMWISE_RETURN_IF_ERROR(at_least(checkpoint_every, 1, "checkpoint_every"));
  ROOMWISE_RETURN_IF_ERROR(at_least(threads, 1, "threads"));
  ROOMWISE_RETURN_IF_ERROR(
      at_least(static_cast<std::int64_t>(loader_threads), 1, "loader_threads"));
  ROOMWISE_RETURN_IF_ERROR(between(rate.base, 1e-12, 1e3, "the learning rate"));
  ROOMWISE_RETURN_IF_ERROR(between(rate.decay, 0, 1, "decay"));
  ROOMWISE_RETURN_IF_ERROR(between(momentum, 0, 0.9999, "momentum"));
  ROOMWISE_RETURN_IF_ERROR(between(weight_decay, 0, 1, "weight_decay"));
  ROOMWISE_RETURN_IF_ERROR(between(label_smoothing, 0, 0.9, "label_smoothing"));
  ROOMWISE_RETURN_IF_ERROR(between(aux_weight, 0, 10, "aux_weight"));
  if (resume && checkpoint.empty()) return fail("resume: there is no checkpoint to go on from");
  return augmentation.validate();
}

std::string TrainingOptions::fingerprint() const {
  const network::AugmentationOptions& a = augmentation;
  return fmt::format(
      "steps {}\nbatch {}\nlearning rate {} schedule {} decay {} every {} warm-up {}\n"
      "optimizer {} momentum {} weight decay {}\nlabel smoothing {}\naux weight {}\nfrom {}\n"
      "augmentation {} {} {} {} {} {} {} {} {} {} {}\nevaluate every {}\nseed {}\n",
      steps, batch, rate.base, static_cast<int>(rate.schedule), rate.decay, rate.decay_every,
      rate.warm_up_steps, static_cast<int>(optimizer), momentum, weight_decay, label_smoothing,
      aux_weight, from, a.exposure_stops, a.lamp_mired, a.tint_stops, a.blur, a.noise,
      a.gamma_stops, a.min_side, a.roll_deg, a.pan_deg, a.tilt_deg, a.mirror, evaluate_every, seed);
}

}  // namespace roomwise::training
