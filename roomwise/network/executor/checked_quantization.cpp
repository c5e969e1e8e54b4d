#include "roomwise/network/executor/checked_quantization.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include "roomwise/base/stage_clock.h"

namespace roomwise::network {
namespace {

// What is tried, one after the other.
constexpr std::array<std::int64_t, 2> kMinChannels{1, 65};
// No network in 8 bits comes so near to one in floats.
constexpr double kFloatRounding = 1e-5;

// 1 for two that are nothing but zeros, 0 where only one is.
double cosine(std::span<const float> a, std::span<const float> b) {
  double product = 0, of_a = 0, of_b = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double x = a[i], y = b[i];
    product += x * y;
    of_a += x * x;
    of_b += y * y;
  }
  if (of_a == 0 || of_b == 0) return of_a == of_b ? 1 : 0;
  return product / std::sqrt(of_a * of_b);
}

double relative_error(std::span<const float> a, std::span<const float> exact) {
  double difference = 0, length = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double x = a[i], y = exact[i];
    difference += (x - y) * (x - y);
    length += y * y;
  }
  if (length == 0) return difference == 0 ? 0 : 1;
  return std::sqrt(difference / length);
}

std::ptrdiff_t place_of_largest(const std::vector<float>& values) {
  return std::ranges::max_element(values) - values.begin();
}

using Outputs = std::vector<Tensor>;

Expected<double> min_cpu_s(const Executor& executor, const Tensor& input) {
  constexpr int kRuns = 3;
  double least = std::numeric_limits<double>::infinity();
  for (int run = 0; run < kRuns; ++run) {
    const double start_s = thread_cpu_time_s();
    ROOMWISE_TRY(const Outputs outputs, executor.run({&input, 1}));
    least = std::min(least, thread_cpu_time_s() - start_s);
  }
  return least;
}

// Runs that are counted and told.
class CountedRuns {
 public:
  CountedRuns(const RunsDone& tell, std::size_t threads) : tell_(tell), threads_(threads) {}

  void begin(std::size_t of) {
    done_ = 0;
    of_ = of;
  }
  [[nodiscard]] Expected<void> count(std::size_t runs) {
    done_ += runs;
    return tell_ ? tell_(done_, of_) : Expected<void>();
  }
  // As run_batch().
  [[nodiscard]] Expected<std::vector<Outputs>> run(const Executor& executor,
                                                   std::span<const Tensor> inputs) {
    const std::size_t few = 4 * std::max<std::size_t>(threads_, 1);
    std::vector<Outputs> all;
    for (std::size_t first = 0; first < inputs.size(); first += few) {
      const auto some = inputs.subspan(first, std::min(few, inputs.size() - first));
      ROOMWISE_TRY(auto outputs, executor.run_batch(some, threads_));
      std::ranges::move(outputs, std::back_inserter(all));
      ROOMWISE_RETURN_IF_ERROR(count(some.size()));
    }
    return all;
  }

 private:
  const RunsDone& tell_;
  std::size_t threads_, done_ = 0, of_ = 0;
};

QuantizationReport compare(std::span<const Outputs> exact, std::span<const Outputs> rounded) {
  QuantizationReport report;
  const double share = 1 / static_cast<double>(exact.size());
  for (std::size_t input = 0; input < exact.size(); ++input) {
    const Outputs& expected = exact[input];
    const Outputs& outputs = rounded[input];
    report.mean_cosine.resize(outputs.size(), 0);
    report.min_cosine.resize(outputs.size(), 1);
    report.mean_error.resize(outputs.size(), 0);
    report.agreement.resize(outputs.size(), 0);
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      const double near = cosine(outputs[i].values, expected[i].values);
      report.mean_cosine[i] += share * near;
      report.min_cosine[i] = std::min(report.min_cosine[i], near);
      report.mean_error[i] += share * relative_error(outputs[i].values, expected[i].values);
      const bool agree =
          place_of_largest(outputs[i].values) == place_of_largest(expected[i].values);
      report.agreement[i] += agree ? share : 0;
    }
  }
  return report;
}

std::string reason_against(const QuantizationReport& report, std::span<const std::size_t> scores,
                           const QuantizationLimits& limits) {
  for (std::size_t i = 0; i < report.mean_cosine.size(); ++i) {
    if (!(report.mean_cosine[i] >= limits.min_cosine)) {
      return fmt::format("output {} in 8 bits has a cosine of {:.4f} with that in floats, below {}",
                         i, report.mean_cosine[i], limits.min_cosine);
    }
    if (!(report.mean_error[i] <= limits.max_error)) {
      return fmt::format("output {} in 8 bits is {:.2f} of its length off that in floats, over {}",
                         i, report.mean_error[i], limits.max_error);
    }
  }
  // Sums of shares may lack a little of 1.
  constexpr double kRounding = 1e-9;
  for (const std::size_t i : scores) {
    if (!(report.agreement[i] + kRounding >= limits.min_agreement)) {
      return fmt::format(
          "output {} in 8 bits has its largest number where floats have it for {:.1f} % "
          "of the inputs, below {:.1f} %",
          i, 100 * report.agreement[i], 100 * limits.min_agreement);
    }
  }
  return "";
}

}  // namespace

Expected<CheckedExecutor> checked_quantization(
    const OnnxGraph& graph, const ExecutorOptions& options, std::span<const Tensor> calibration,
    std::span<const Tensor> held_out, std::span<const std::size_t> scores,
    const QuantizationLimits& limits, std::size_t threads, const RunsDone& runs_done) {
  if (calibration.empty() || held_out.empty())
    return fail("8 bits need inputs to measure on, and others to be checked on");
  ExecutorOptions in_floats = options;
  in_floats.eight_bits.reset();
  ROOMWISE_TRY(auto exact, Executor::create(graph, in_floats));
  CountedRuns runs(runs_done, threads);
  runs.begin(2 * held_out.size() + calibration.size());
  ROOMWISE_TRY(const auto exact_outputs, runs.run(*exact, held_out));
  for (const std::size_t i : scores) {
    if (i >= exact_outputs.front().size())
      return fail("there is no output {} among {}", i, exact_outputs.front().size());
  }
  ROOMWISE_TRY(EightBitRanges ranges, calibrate_eight_bits(graph, in_floats, calibration));
  ROOMWISE_RETURN_IF_ERROR(runs.count(calibration.size()));
  QuantizationReport report;
  report.reason = "nothing in it can be held in 8 bits";
  for (const std::int64_t min_channels : kMinChannels) {
    if (min_channels != kMinChannels.front()) runs.begin(held_out.size());
    ranges.min_channels = min_channels;
    ExecutorOptions in_eight_bits = in_floats;
    in_eight_bits.eight_bits = ranges;
    ROOMWISE_TRY(auto rounded, Executor::create(graph, in_eight_bits));
    ROOMWISE_TRY(const auto outputs, runs.run(*rounded, held_out));
    QuantizationReport compared = compare(exact_outputs, outputs);
    // Nothing has so many channels: that is the network in floats.
    if (*std::ranges::max_element(compared.mean_error) < kFloatRounding) break;
    report = std::move(compared);
    report.min_channels = min_channels;
    report.reason = reason_against(report, scores, limits);
    report.is_used = report.reason.empty();
    if (!report.is_used) continue;
    ROOMWISE_TRY(const double exact_s, min_cpu_s(*exact, held_out.front()));
    ROOMWISE_TRY(const double rounded_s, min_cpu_s(*rounded, held_out.front()));
    report.time_ratio = rounded_s / exact_s;
    return CheckedExecutor{std::move(rounded), std::move(ranges), std::move(report)};
  }
  return CheckedExecutor{std::move(exact), std::nullopt, std::move(report)};
}

}  // namespace roomwise::network
