#include "roomwise/pipeline/rooms/predict_pictures.h"

#include "roomwise/base/stopwatch.h"
#include "roomwise/pipeline/in_blocks.h"

namespace roomwise::pipeline {

Expected<std::vector<TimedPrediction>> predict_pictures(
    std::size_t count, const std::function<Expected<image::ColorImage>(std::size_t)>& read,
    const network::Classifier& network, std::string_view work, RunContext& run) {
  std::vector<TimedPrediction> predictions;
  // Pictures are read on the pool's threads, too.
  const auto index = [](std::size_t i) -> Expected<std::size_t> { return i; };
  const auto predict = [&](std::size_t i, std::size_t) -> Expected<TimedPrediction> {
    ROOMWISE_TRY(const image::ColorImage picture, read(i));
    const auto timing = run.clock.measure("network " + network.name());
    const Stopwatch watch;
    ROOMWISE_TRY(network::Prediction prediction, network.predict(picture));
    return TimedPrediction{std::move(prediction), watch.ms()};
  };
  const auto take = [&](std::size_t, TimedPrediction prediction) -> Expected<void> {
    predictions.push_back(std::move(prediction));
    return {};
  };
  ROOMWISE_RETURN_IF_ERROR(in_blocks(count, work, run, index, predict, take));
  return predictions;
}

}  // namespace roomwise::pipeline
