#pragma once

#include <functional>

#include "roomwise/network/executor/executor.h"

namespace roomwise::network {

// How near a network in 8 bits must come to the one in floats to be used, on inputs that its steps
// were not measured on.
struct QuantizationLimits {
  double min_cosine = 0.99;     // of every output, in the mean of the inputs
  double min_agreement = 0.98;  // of the largest number's place, for outputs that are scores
  // The length of the difference over that of what floats give, in the mean of the inputs: a wrong
  // scale is no matter to the other two.
  double max_error = 0.3;
};

// What a network in 8 bits gives beside the one in floats.
struct QuantizationReport {
  std::vector<double> mean_cosine;  // an output each
  std::vector<double> min_cosine;   // the same, of the worst input
  std::vector<double> mean_error;   // length of the difference, over that of the output in floats
  std::vector<double> agreement;    // part of the inputs whose largest number is at one place
  // EightBitRanges::min_channels of these figures.
  std::int64_t min_channels = 1;
  // The processor time of one input, over that in floats: the least of a few runs each.
  double time_ratio = 1;
  bool is_used = false;
  std::string reason;  // why it is not used; empty: it is
};

// Told after every few inputs how many runs of the network are done, and of how many; where the
// first try does not come near enough, of the second's. What fails ends the work.
using RunsDone = std::function<Expected<void>(std::size_t done, std::size_t of)>;

struct CheckedExecutor {
  std::unique_ptr<Executor> executor;
  std::optional<EightBitRanges> eight_bits;  // with which it runs; absent: in floats
  QuantizationReport report;
};

// The network in 8 bits, measured on `calibration`, where it is near enough on `held_out`; else the
// same with what has up to 64 channels in floats, where that is; else in floats, with the reason.
// scores: which of the outputs' largest numbers must agree, by their places. Fails where either
// network cannot be run, or there are no inputs to measure or to check it on.
[[nodiscard]] Expected<CheckedExecutor> checked_quantization(
    const OnnxGraph& graph, const ExecutorOptions& options, std::span<const Tensor> calibration,
    std::span<const Tensor> held_out, std::span<const std::size_t> scores,
    const QuantizationLimits& limits = {}, std::size_t threads = 1, const RunsDone& runs_done = {});

}  // namespace roomwise::network
