#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <utility>

#include "roomwise/base/expected.h"

// What benchmarks do around what they measure.
namespace roomwise::bench {

// A value, or the end of the program with the error.
template <typename Value>
Value need(Expected<Value> value) {
  if (!value) {
    fmt::print(stderr, "{}\n", value.error().message);
    std::exit(1);
  }
  return std::move(*value);
}

inline void need_done(const Expected<void>& done) {
  if (done) return;
  fmt::print(stderr, "{}\n", done.error().message);
  std::exit(1);
}

// Processor time of this process so far.
inline double cpu_ms() {
  return 1000.0 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

// CPU-ms of one call, which is repeated until all have taken `min_ms`.
inline double cpu_ms_of(const std::function<void()>& call, double min_ms) {
  int calls = 0;
  const double begin = cpu_ms();
  do {
    call();
    ++calls;
  } while (cpu_ms() - begin < min_ms);
  return (cpu_ms() - begin) / calls;
}

}  // namespace roomwise::bench
