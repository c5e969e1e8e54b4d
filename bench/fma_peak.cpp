#include "fma_peak.h"

#include <immintrin.h>

#include <algorithm>
#include <array>
#include <ctime>

namespace roomwise::bench {
namespace {

// Enough independent sums to keep two units of four cycles' latency busy.
constexpr std::size_t kSums = 12;
constexpr int kRepetitions = 500'000;

[[gnu::target("avx512f")]] float many_sums_512() {
  __m512 sums[kSums];
  for (std::size_t i = 0; i < kSums; ++i) sums[i] = _mm512_set1_ps(static_cast<float>(i));
  const __m512 factor = _mm512_set1_ps(0.999F), term = _mm512_set1_ps(0.001F);
  for (int repetition = 0; repetition < kRepetitions; ++repetition) {
#pragma GCC unroll 12
    for (std::size_t i = 0; i < kSums; ++i) sums[i] = _mm512_fmadd_ps(sums[i], factor, term);
  }
  alignas(64) std::array<float, 16> values{};
  float total = 0;
  for (const __m512& sum : sums) {
    _mm512_store_ps(values.data(), sum);
    for (const float value : values) total += value;
  }
  return total;
}

[[gnu::target("avx2,fma")]] float many_sums_256() {
  __m256 sums[kSums];
  for (std::size_t i = 0; i < kSums; ++i) sums[i] = _mm256_set1_ps(static_cast<float>(i));
  const __m256 factor = _mm256_set1_ps(0.999F), term = _mm256_set1_ps(0.001F);
  for (int repetition = 0; repetition < kRepetitions; ++repetition) {
#pragma GCC unroll 12
    for (std::size_t i = 0; i < kSums; ++i) sums[i] = _mm256_fmadd_ps(sums[i], factor, term);
  }
  alignas(32) std::array<float, 8> values{};
  float total = 0;
  for (const __m256& sum : sums) {
    _mm256_store_ps(values.data(), sum);
    for (const float value : values) total += value;
  }
  return total;
}

bool has_512() {
  return __builtin_cpu_supports("avx512f") != 0;
}

}  // namespace

double fma_peak_gflops() {
  double best = 0;
  for (int round = 0; round < 5; ++round) {
    const std::clock_t begin = std::clock();
    volatile float kept = has_512() ? many_sums_512() : many_sums_256();
    (void)kept;
    const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    const double operations =
        2.0 * (has_512() ? 16 : 8) * static_cast<double>(kSums) * kRepetitions;
    best = std::max(best, operations / seconds / 1e9);
  }
  return best;
}

std::string fma_peak_instructions() {
  return has_512() ? "AVX-512" : "AVX2";
}

}  // namespace roomwise::bench
