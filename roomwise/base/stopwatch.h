#pragma once

#include <chrono>

namespace roomwise {

[[nodiscard]] inline double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// Runs from its making on.
class Stopwatch {
 public:
  [[nodiscard]] double ms() const { return 1e3 * seconds_since(start_); }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace roomwise
