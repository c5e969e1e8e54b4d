#include "roomwise/evaluation/statistics/quantile.h"

#include <fmt/format.h>

#include <algorithm>

namespace roomwise::evaluation {

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::ranges::sort(values);
  const double place = std::clamp(share, 0.0, 1.0) * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  const double part = place - static_cast<double>(below);
  return (1 - part) * values[below] + part * values[above];
}

std::string middle_and_range(std::vector<double> values, int decimals) {
  std::ranges::sort(values);
  if (values.front() == values.back()) return fmt::format("{:.{}f}", values.front(), decimals);
  return fmt::format("{:.{}f} ({:.{}f} to {:.{}f})", values[values.size() / 2], decimals,
                     values.front(), decimals, values.back(), decimals);
}

}  // namespace roomwise::evaluation
