#include "roomwise/evaluation/report/reliability.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "roomwise/evaluation/report/report_page.h"

namespace roomwise::evaluation {

std::vector<Forecast> forecasts_of(const ObjectErrors& errors, std::span<const TrueObject> truth,
                                   std::span<const double> probabilities) {
  std::vector<Forecast> forecasts;
  for (const ObjectMatch& match : errors.matches) {
    if (truth[match.truth].is_expected) forecasts.push_back({probabilities[match.found], true});
  }
  for (const ObjectMatch& match : errors.duplicates) {
    forecasts.push_back({probabilities[match.found], false});
  }
  for (const std::size_t found : errors.wrong) forecasts.push_back({probabilities[found], false});
  return forecasts;
}

std::vector<ReliabilityBin> reliability_curve(std::span<const Forecast> forecasts, int bins) {
  std::vector<ReliabilityBin> curve(static_cast<std::size_t>(bins));
  for (int i = 0; i < bins; ++i) {
    curve[static_cast<std::size_t>(i)].low = static_cast<double>(i) / bins;
    curve[static_cast<std::size_t>(i)].high = static_cast<double>(i + 1) / bins;
  }
  for (const Forecast& forecast : forecasts) {
    const int place = std::clamp(static_cast<int>(forecast.probability * bins), 0, bins - 1);
    ReliabilityBin& bin = curve[static_cast<std::size_t>(place)];
    bin.right.add(forecast.is_right);
    bin.mean += (forecast.probability - bin.mean) / static_cast<double>(bin.right.n);
  }
  return curve;
}

double calibration_error(std::span<const ReliabilityBin> bins) {
  double off = 0, n = 0;
  for (const ReliabilityBin& bin : bins) {
    const auto here = static_cast<double>(bin.right.n);
    off += here * std::abs(bin.right.value() - bin.mean);
    n += here;
  }
  return n == 0 ? 0 : off / n;
}

std::string reliability_table(const std::string& caption, std::span<const ReliabilityBin> bins) {
  std::vector<std::vector<std::string>> rows;
  for (const ReliabilityBin& bin : bins) {
    const Interval interval = bin.right.wilson_interval();
    const bool is_empty = bin.right.n == 0;
    rows.push_back(
        {fmt::format("{} to {}", percent(bin.low), percent(bin.high)), std::to_string(bin.right.n),
         is_empty ? "–" : percent(bin.mean), percent_of(bin.right),
         is_empty ? "–" : fmt::format("{} to {}", percent(interval.low), percent(interval.high))});
  }
  return report_table(caption, {"Said with", "Things", "In the mean", "Right", "95 % interval"},
                      rows);
}

}  // namespace roomwise::evaluation
