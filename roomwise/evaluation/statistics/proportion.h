#pragma once

#include <cstdint>
#include <string>

namespace roomwise::evaluation {

struct Interval {
  double low = 0;
  double high = 0;
};

// How often something succeeded.
struct Proportion {
  std::uint64_t successes = 0;
  std::uint64_t n = 0;

  void add(bool success) {
    successes += success ? 1 : 0;
    ++n;
  }
  // successes / n; 0 without any trial.
  [[nodiscard]] double value() const;
  // Wilson's score interval at 95 % confidence (E. B. Wilson, 1927), which holds near 0 and 1 and
  // for few trials too; 0 to 1 without any. It takes trials as independent: for frames of a few
  // walks it is too narrow.
  [[nodiscard]] Interval wilson_interval() const;

  friend bool operator==(const Proportion&, const Proportion&) = default;
};

// As people read it: "97.5 %".
[[nodiscard]] std::string percent(double share);
// The same of a proportion; a dash where nothing was counted.
[[nodiscard]] std::string percent_of(const Proportion& proportion);

}  // namespace roomwise::evaluation
