#pragma once

#include <string>

namespace roomwise::bench {

// How many billion floating-point operations a second one thread of this processor does at most, as
// multiply-adds that wait for nothing, measured now (some 20 CPU-ms).
[[nodiscard]] double fma_peak_gflops();

// By which instructions: "AVX-512" or "AVX2".
[[nodiscard]] std::string fma_peak_instructions();

}  // namespace roomwise::bench
