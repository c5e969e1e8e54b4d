#include "roomwise/features/quantized_descriptors.h"

#include <algorithm>
#include <array>
#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>

#include <utility>
#endif

namespace roomwise::features {
namespace {

constexpr std::size_t kBlock = QuantizedDescriptors::kBlock;

std::int16_t to_whole(float value) {
  constexpr auto kUnit = static_cast<float>(QuantizedDescriptors::kUnit);
  const float units = kUnit * std::clamp(value, -1.0F, 1.0F);
  return static_cast<std::int16_t>(units + (units < 0 ? -0.5F : 0.5F));
}

void multiply_blocks(const std::int16_t* a, const std::int16_t* b, std::size_t pairs,
                     std::int32_t* products, std::size_t stride) {
  std::array<std::array<std::int32_t, kBlock>, kBlock> sums{};
  for (std::size_t p = 0; p < pairs; ++p, a += 2 * kBlock, b += 2 * kBlock) {
    for (std::size_t i = 0; i < kBlock; ++i) {
      for (std::size_t j = 0; j < kBlock; ++j)
        sums[i][j] += a[2 * i] * b[2 * j] + a[2 * i + 1] * b[2 * j + 1];
    }
  }
  for (std::size_t i = 0; i < kBlock; ++i) std::ranges::copy(sums[i], products + i * stride);
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) void multiply_blocks_avx2(const std::int16_t* a,
                                                          const std::int16_t* b, std::size_t pairs,
                                                          std::int32_t* products,
                                                          std::size_t stride) {
  __m256i sums[kBlock];  // NOLINT: std::array would lose their alignment
  for (__m256i& sum : sums) sum = _mm256_setzero_si256();
  for (std::size_t p = 0; p < pairs; ++p, a += 2 * kBlock, b += 2 * kBlock) {
    const __m256i b_pairs = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(b));
#pragma GCC unroll 8
    for (std::size_t i = 0; i < kBlock; ++i) {
      std::int32_t a_pair = 0;
      std::memcpy(&a_pair, a + 2 * i, sizeof a_pair);
      sums[i] = _mm256_add_epi32(sums[i], _mm256_madd_epi16(_mm256_set1_epi32(a_pair), b_pairs));
    }
  }
  for (std::size_t i = 0; i < kBlock; ++i)
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(products + i * stride), sums[i]);
}
#elif defined(__aarch64__)
// Adds the products of one descriptor of a, whose pair is at lane `pair` of a_pairs, with all of b.
template <int pair>
[[gnu::always_inline]] inline void add_products(int16x8_t a_pairs, const int16x8x2_t& b,
                                                int32x4_t& low, int32x4_t& high) {
  low = vmlal_laneq_s16(low, vget_low_s16(b.val[0]), a_pairs, 2 * pair);
  low = vmlal_laneq_s16(low, vget_low_s16(b.val[1]), a_pairs, 2 * pair + 1);
  high = vmlal_high_laneq_s16(high, b.val[0], a_pairs, 2 * pair);
  high = vmlal_high_laneq_s16(high, b.val[1], a_pairs, 2 * pair + 1);
}

void multiply_blocks_neon(const std::int16_t* a, const std::int16_t* b, std::size_t pairs,
                          std::int32_t* products, std::size_t stride) {
  constexpr std::size_t kHalf = kBlock / 2;  // descriptors whose pairs fill a register
  int32x4_t sums[kBlock][2] = {};            // NOLINT: std::array would lose their registers
  for (std::size_t p = 0; p < pairs; ++p, a += 2 * kBlock, b += 2 * kBlock) {
    const int16x8x2_t b_pairs = vld2q_s16(b);  // firsts and seconds apart
    const int16x8_t first = vld1q_s16(a), second = vld1q_s16(a + kBlock);
    [&]<int... i>(std::integer_sequence<int, i...>) __attribute__((always_inline)) {
      (add_products<i>(first, b_pairs, sums[i][0], sums[i][1]), ...);
      (add_products<i>(second, b_pairs, sums[kHalf + i][0], sums[kHalf + i][1]), ...);
    }
    (std::make_integer_sequence<int, kHalf>());
  }
  for (std::size_t i = 0; i < kBlock; ++i) {
    vst1q_s32(products + i * stride, sums[i][0]);
    vst1q_s32(products + i * stride + kHalf, sums[i][1]);
  }
}
#endif

}  // namespace

QuantizedDescriptors::QuantizedDescriptors(const FloatDescriptors& descriptors,
                                           std::span<const std::uint32_t> rows)
    : size_(rows.size()),
      pairs_((static_cast<std::size_t>(descriptors.cols()) + 1) / 2),
      values_(blocks() * kBlock * 2 * pairs_, 0),
      squared_lengths_(blocks() * kBlock, 0) {
  std::vector<std::int16_t> wholes(2 * pairs_, 0);
  for (std::size_t i = 0; i < size_; ++i) {
    const auto row = descriptors.row(rows[i]);
    std::transform(row.data(), row.data() + row.size(), wholes.begin(), to_whole);
    for (const std::int16_t whole : wholes) squared_lengths_[i] += whole * whole;
    std::int16_t* pair = values_.data() + 2 * (i / kBlock * kBlock * pairs_ + i % kBlock);
    for (std::size_t p = 0; p < pairs_; ++p, pair += 2 * kBlock)
      std::copy_n(&wholes[2 * p], 2, pair);
  }
}

BlockProducts block_products([[maybe_unused]] Simd simd) {
#if defined(__x86_64__)
  if (simd == Simd::kAvx2) return multiply_blocks_avx2;
#elif defined(__aarch64__)
  if (simd == Simd::kNeon) return multiply_blocks_neon;
#endif
  return multiply_blocks;
}

}  // namespace roomwise::features
