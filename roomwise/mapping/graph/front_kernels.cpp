#include "roomwise/mapping/graph/front_kernels.h"

#include <cmath>

#include "roomwise/base/simd.h"

namespace roomwise::mapping {
namespace {

// Takes L_r L_b^T from `target`, Lanes * Numbers rows by kBlock columns: L_r are the rows of a
// panel's `depth` columns that start at `rows`, L_b the kBlock rows at `block`. The products are
// held in registers.
template <std::size_t Lanes, std::size_t Numbers>
[[gnu::always_inline]] inline void subtract_tile(const double* rows, const double* block,
                                                 std::size_t depth, std::size_t stride,
                                                 double* target, std::size_t target_stride) {
  // Read and written wherever numbers may lie.
  using Lane [[gnu::vector_size(Numbers * sizeof(double)), gnu::aligned(sizeof(double))]] = double;
  Lane sums[kBlock][Lanes] = {};
  for (std::size_t k = 0; k < depth; ++k, rows += stride, block += stride) {
#pragma GCC unroll 6
    for (std::size_t c = 0; c < kBlock; ++c) {
#pragma GCC unroll 4
      for (std::size_t l = 0; l < Lanes; ++l)
        sums[c][l] += reinterpret_cast<const Lane*>(rows)[l] * block[c];
    }
  }
#pragma GCC unroll 6
  for (std::size_t c = 0; c < kBlock; ++c) {
#pragma GCC unroll 4
    for (std::size_t l = 0; l < Lanes; ++l)
      reinterpret_cast<Lane*>(target + c * target_stride)[l] -= sums[c][l];
  }
}

// The same for any even number of rows, `Numbers` of which are a vector.
template <std::size_t Numbers>
[[gnu::always_inline]] inline void subtract_column(const double* rows, std::size_t count,
                                                   const double* block, std::size_t depth,
                                                   std::size_t stride, double* target,
                                                   std::size_t target_stride) {
  std::size_t r = 0;
  for (; r + kLane <= count; r += kLane)
    subtract_tile<kLane / Numbers, Numbers>(rows + r, block, depth, stride, target + r,
                                            target_stride);
  for (; r < count; r += 2)
    subtract_tile<1, 2>(rows + r, block, depth, stride, target + r, target_stride);
}

// Cholesky's method on one block column from its diagonal down.
[[gnu::always_inline]] inline bool eliminate_block(double* column, std::size_t rows,
                                                   std::size_t stride) {
  for (std::size_t c = 0; c < kBlock; ++c) {
    double* const own = column + c * stride;
    for (std::size_t k = 0; k < c; ++k) {
      const double* const before = column + k * stride;
      const double factor = before[c];
      for (std::size_t r = c; r < rows; ++r) own[r] -= factor * before[r];
    }
    if (!(own[c] > 0) || !std::isfinite(own[c])) return false;
    const double pivot = std::sqrt(own[c]);
    const double inverse = 1 / pivot;
    own[c] = pivot;
    for (std::size_t r = c + 1; r < rows; ++r) own[r] *= inverse;
  }
  return true;
}

template <std::size_t Numbers>
[[gnu::always_inline]] inline bool eliminate_any(const Panel& panel) {
  for (std::size_t column = 0; column < panel.columns; ++column) {
    const std::size_t first = column * kBlock;
    double* const diagonal = panel.numbers + first * panel.stride + first;
    const std::size_t rows = panel.stride - first;
    subtract_column<Numbers>(panel.numbers + first, rows, panel.numbers + first, first,
                             panel.stride, diagonal, panel.stride);
    if (!eliminate_block(diagonal, rows, panel.stride)) return false;
  }
  return true;
}

template <std::size_t Numbers>
[[gnu::always_inline]] inline void subtract_products_any(const Panel& panel, std::size_t blocks,
                                                         double* left) {
  const std::size_t depth = panel.columns * kBlock;
  const std::size_t stride = padded(blocks * kBlock);
  const double* const below = panel.numbers + depth;
  for (std::size_t block = 0; block < blocks; ++block) {
    // Whole lanes: a few rows above the diagonal, which nobody reads, change too.
    const std::size_t first = block * kBlock;
    const std::size_t start = first / kLane * kLane;
    subtract_column<Numbers>(below + start, stride - start, below + first, depth, panel.stride,
                             left + first * stride + start, stride);
  }
}

constexpr std::size_t kPortableNumbers = 4;
#if defined(__x86_64__)
// The same code, four numbers at a time: the same bits.
[[gnu::target("avx2")]] bool eliminate_avx2(const Panel& panel) {
  return eliminate_any<4>(panel);
}
[[gnu::target("avx2")]] void subtract_products_avx2(const Panel& panel, std::size_t blocks,
                                                    double* left) {
  subtract_products_any<4>(panel, blocks, left);
}
#elif defined(__aarch64__)
// Two, as NEON has them: the same bits.
constexpr std::size_t kNeonNumbers = 2;
#endif

}  // namespace

bool eliminate(const Panel& panel) {
#if defined(__x86_64__)
  if (process_simd() == Simd::kAvx2) return eliminate_avx2(panel);
#elif defined(__aarch64__)
  if (process_simd() == Simd::kNeon) return eliminate_any<kNeonNumbers>(panel);
#endif
  return eliminate_any<kPortableNumbers>(panel);
}

void subtract_products(const Panel& panel, std::size_t blocks, double* left) {
#if defined(__x86_64__)
  if (process_simd() == Simd::kAvx2) return subtract_products_avx2(panel, blocks, left);
#elif defined(__aarch64__)
  if (process_simd() == Simd::kNeon)
    return subtract_products_any<kNeonNumbers>(panel, blocks, left);
#endif
  subtract_products_any<kPortableNumbers>(panel, blocks, left);
}

}  // namespace roomwise::mapping
