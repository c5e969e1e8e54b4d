#pragma once

#include <span>
#include <string>
#include <vector>

#include "roomwise/evaluation/errors/object_error.h"
#include "roomwise/evaluation/statistics/proportion.h"

namespace roomwise::evaluation {

// Something said with a probability, and whether it was so.
struct Forecast {
  double probability = 0;  // [0, 1]
  bool is_right = false;
};

// Of things that were found, each with its probability; those that need not be found are left out,
// found twice counts as wrong.
[[nodiscard]] std::vector<Forecast> forecasts_of(const ObjectErrors& errors,
                                                 std::span<const TrueObject> truth,
                                                 std::span<const double> probabilities);

// Those of like probability.
struct ReliabilityBin {
  double low = 0, high = 0;  // of the probabilities; high itself is in the last one alone
  double mean = 0;           // of them; 0 without any
  Proportion right;
};

// The reliability curve, in so many bins of equal width (Murphy 1973): of what is said with 0.7,
// seven of ten are right.
[[nodiscard]] std::vector<ReliabilityBin> reliability_curve(std::span<const Forecast> forecasts,
                                                            int bins = 5);
// How far the bins are off in the mean, those with more forecasts weighing more (the expected
// calibration error); 0 without any.
[[nodiscard]] double calibration_error(std::span<const ReliabilityBin> bins);

// As a table of a page; what is in it is in the caption.
[[nodiscard]] std::string reliability_table(const std::string& caption,
                                            std::span<const ReliabilityBin> bins);

}  // namespace roomwise::evaluation
