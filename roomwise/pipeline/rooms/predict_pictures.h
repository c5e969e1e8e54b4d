#pragma once

#include <functional>
#include <string_view>
#include <vector>

#include "roomwise/network/vision/classifier.h"
#include "roomwise/pipeline/run_context.h"

namespace roomwise::pipeline {

struct TimedPrediction {
  network::Prediction prediction;
  double ms = 0;  // wall time of the network alone
};

// Shows pictures 0 to count - 1 to a network, on all threads. Fails at the first picture that
// cannot be read, or when the user interrupts.
[[nodiscard]] Expected<std::vector<TimedPrediction>> predict_pictures(
    std::size_t count, const std::function<Expected<image::ColorImage>(std::size_t)>& read,
    const network::Classifier& network, std::string_view work, RunContext& run);

}  // namespace roomwise::pipeline
