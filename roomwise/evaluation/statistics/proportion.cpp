#include "roomwise/evaluation/statistics/proportion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace roomwise::evaluation {

double Proportion::value() const {
  return n == 0 ? 0 : static_cast<double>(successes) / static_cast<double>(n);
}

Interval Proportion::wilson_interval() const {
  if (n == 0) return {0, 1};
  constexpr double kZ = 1.959963984540054;  // the normal distribution's 97.5 % quantile
  const double trials = static_cast<double>(n);
  const double share = value();
  const double shrink = 1 / (1 + kZ * kZ / trials);
  const double centre = shrink * (share + kZ * kZ / (2 * trials));
  const double half_width =
      shrink * kZ * std::sqrt(share * (1 - share) / trials + kZ * kZ / (4 * trials * trials));
  return {std::max(0.0, centre - half_width), std::min(1.0, centre + half_width)};
}

std::string percent(double share) {
  return fmt::format("{:.1f} %", 100 * share);
}

std::string percent_of(const Proportion& proportion) {
  return proportion.n == 0 ? "–" : percent(proportion.value());
}

}  // namespace roomwise::evaluation
