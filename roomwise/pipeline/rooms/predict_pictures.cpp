#include "roomwise/pipeline/rooms/predict_pictures.h"

#include <chrono>

namespace roomwise::pipeline {

Expected<std::vector<TimedPrediction>> predict_pictures(
    std::size_t count, const std::function<Expected<image::ColorImage>(std::size_t)>& read,
    const network::Classifier& network, std::string_view work, RunContext& run) {
  std::vector<Expected<TimedPrediction>> results(count);
  const auto predict = [&](std::size_t i) {
    results[i] = [&]() -> Expected<TimedPrediction> {
      ROOMWISE_TRY(const image::ColorImage picture, read(i));
      const auto timing = run.clock.measure("network " + network.name());
      const auto start = std::chrono::steady_clock::now();
      ROOMWISE_TRY(network::Prediction prediction, network.predict(picture));
      const std::chrono::duration<double, std::milli> elapsed =
          std::chrono::steady_clock::now() - start;
      return TimedPrediction{std::move(prediction), elapsed.count()};
    }();
  };
  run.progress.begin(work, count);
  // In blocks, so that progress is told and an interruption heard.
  const std::size_t block = 4 * run.pool.size();
  for (std::size_t first = 0; first < count; first += block) {
    if (run.progress.interrupted()) {
      run.progress.end();
      return fail("interrupted after {} of {} pictures", first, count);
    }
    const std::size_t in_block = std::min(block, count - first);
    run.pool.parallel_for(in_block, [&](std::size_t i) { predict(first + i); });
    run.progress.advance(first + in_block, "");
  }
  run.progress.end();
  std::vector<TimedPrediction> predictions;
  predictions.reserve(count);
  for (auto& result : results) {
    if (!result) return Unexpected(std::move(result).error());
    predictions.push_back(*std::move(result));
  }
  return predictions;
}

}  // namespace roomwise::pipeline
