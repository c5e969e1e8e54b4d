#include "roomwise/rooms/statistics/sample_products.h"

#include <algorithm>
#include <cstring>

namespace roomwise::rooms {
namespace {

constexpr std::size_t kRows = SampleBlocks::kRows;
// Features at a time: their weights stay in the processor's nearest cache.
constexpr std::size_t kFeatures = 128;
// Sums that are held in registers at a time: of four rows and two vectors of columns.
constexpr std::size_t kHeldRows = 4;

// Sixteen numbers at a time, for AVX-512. Each column's sum is its own, so that it makes no
// difference how many are taken at a time.
using Float16 = float __attribute__((vector_size(64)));

template <typename Vector>
constexpr std::size_t kLanes = sizeof(Vector) / sizeof(float);
template <typename Vector>
[[gnu::always_inline]] inline void get(const float* from, Vector& to) {
  std::memcpy(&to, from, sizeof to);
}
template <typename Vector>
[[gnu::always_inline]] inline void put(const Vector& from, float* to) {
  std::memcpy(to, &from, sizeof from);
}

// sums (kHeldRows x the lanes of kVectors, `stride` apart) += samples^T times weights, over `count`
// features.
template <typename Vector, std::size_t kVectors>
[[gnu::always_inline]] inline void multiply_tile(const float* samples, std::size_t count,
                                                 const float* weights, std::size_t stride,
                                                 float* sums) {
  Vector held[kHeldRows][kVectors];
  for (std::size_t r = 0; r < kHeldRows; ++r) {
    for (std::size_t v = 0; v < kVectors; ++v) {
      get(sums + r * stride + kLanes<Vector> * v, held[r][v]);
    }
  }
  for (std::size_t k = 0; k < count; ++k) {
    Vector weight[kVectors];
    for (std::size_t v = 0; v < kVectors; ++v) {
      get(weights + k * stride + kLanes<Vector> * v, weight[v]);
    }
    for (std::size_t r = 0; r < kHeldRows; ++r) {
      const float sample = samples[k * kRows + r];
      for (std::size_t v = 0; v < kVectors; ++v) held[r][v] += sample * weight[v];
    }
  }
  for (std::size_t r = 0; r < kHeldRows; ++r) {
    for (std::size_t v = 0; v < kVectors; ++v) {
      put(held[r][v], sums + r * stride + kLanes<Vector> * v);
    }
  }
}

// sums (kHeldRows features x the lanes of kVectors, `stride` apart) += samples times residuals,
// over kRows.
template <typename Vector, std::size_t kVectors>
[[gnu::always_inline]] inline void transposed_tile(const float* samples, const float* residuals,
                                                   std::size_t stride, std::size_t features,
                                                   float* sums) {
  Vector held[kHeldRows][kVectors] = {};
  for (std::size_t row = 0; row < kRows; ++row) {
    Vector residual[kVectors];
    for (std::size_t v = 0; v < kVectors; ++v) {
      get(residuals + row * stride + kLanes<Vector> * v, residual[v]);
    }
    for (std::size_t k = 0; k < kHeldRows; ++k) {
      // Past the last feature there is nothing; its sum is not stored.
      const float sample = samples[std::min(k, features - 1) * kRows + row];
      for (std::size_t v = 0; v < kVectors; ++v) held[k][v] += sample * residual[v];
    }
  }
  for (std::size_t k = 0; k < std::min(kHeldRows, features); ++k) {
    for (std::size_t v = 0; v < kVectors; ++v) {
      Vector sum;
      get(sums + k * stride + kLanes<Vector> * v, sum);
      put(sum + held[k][v], sums + k * stride + kLanes<Vector> * v);
    }
  }
}

// Cuts `columns`, a multiple of eight, into pieces for two, one, or half of a vector:
// tile.template operator()<Vector, kVectors>(first_column).
template <typename Vector, typename Tile>
[[gnu::always_inline]] inline void for_each_tile(std::size_t columns, const Tile& tile) {
  constexpr std::size_t kWidth = kLanes<Vector>;
  std::size_t column = 0;
  for (; column + 2 * kWidth <= columns; column += 2 * kWidth) {
    tile.template operator()<Vector, 2>(column);
  }
  if (column + kWidth <= columns) {
    tile.template operator()<Vector, 1>(column);
    column += kWidth;
  }
  if (column < columns) tile.template operator()<Float8, 1>(column);
}

template <typename Vector>
[[gnu::always_inline]] inline void multiply_block(const float* samples, std::size_t features,
                                                  const PaddedRows& weights, PaddedRows& sums) {
  const std::size_t columns = weights.columns;
  std::fill_n(sums.values.data(), kRows * columns, 0.0F);
  for (std::size_t first = 0; first < features; first += kFeatures) {
    const std::size_t count = std::min(kFeatures, features - first);
    for (std::size_t row = 0; row < kRows; row += kHeldRows) {
      const float* here = samples + first * kRows + row;
      for_each_tile<Vector>(
          columns, [&]<typename V, std::size_t kVectors>(std::size_t column)
                       __attribute__((always_inline)) {
                         multiply_tile<V, kVectors>(here, count, weights.row(first) + column,
                                                    columns, sums.row(row) + column);
                       });
    }
  }
}

template <typename Vector>
[[gnu::always_inline]] inline void add_transposed_block(const float* samples, std::size_t features,
                                                        const PaddedRows& residuals,
                                                        PaddedRows& sums) {
  const std::size_t columns = residuals.columns;
  for (std::size_t first = 0; first < features; first += kHeldRows) {
    const float* here = samples + first * kRows;
    for_each_tile<Vector>(
        columns, [&]<typename V, std::size_t kVectors>(std::size_t column)
                     __attribute__((always_inline)) {
                       transposed_tile<V, kVectors>(here, residuals.row(0) + column, columns,
                                                    features - first, sums.row(first) + column);
                     });
  }
}

using Product = void(const float* samples, std::size_t features, const PaddedRows& right,
                     PaddedRows& sums);
struct Kernels {
  Product* multiply;
  Product* add_transposed;
};

#define ROOMWISE_KERNELS(name, Vector, ...)                                               \
  __VA_ARGS__ void name##_multiply(const float* samples, std::size_t features,            \
                                   const PaddedRows& weights, PaddedRows& sums) {         \
    multiply_block<Vector>(samples, features, weights, sums);                             \
  }                                                                                       \
  __VA_ARGS__ void name##_add_transposed(const float* samples, std::size_t features,      \
                                         const PaddedRows& residuals, PaddedRows& sums) { \
    add_transposed_block<Vector>(samples, features, residuals, sums);                     \
  }
ROOMWISE_KERNELS(portable, Float8)
ROOMWISE_KERNELS(avx2, Float8, __attribute__((target("avx2"))))
ROOMWISE_KERNELS(avx512, Float16, __attribute__((target("avx512f"))))
#undef ROOMWISE_KERNELS

Kernels kernels_for(ProductSimd simd) {
  switch (simd) {
    case ProductSimd::kAvx512:
      return {avx512_multiply, avx512_add_transposed};
    case ProductSimd::kAvx2:
      return {avx2_multiply, avx2_add_transposed};
    case ProductSimd::kPortable:
      break;
  }
  return {portable_multiply, portable_add_transposed};
}

}  // namespace

bool is_supported(ProductSimd simd) {
  if (simd == ProductSimd::kAvx512) return __builtin_cpu_supports("avx512f") != 0;
  return is_supported(simd == ProductSimd::kAvx2 ? Simd::kAvx2 : Simd::kPortable);
}

ProductSimd process_product_simd() {
  if (process_simd() == Simd::kPortable) return ProductSimd::kPortable;
  return is_supported(ProductSimd::kAvx512) ? ProductSimd::kAvx512 : ProductSimd::kAvx2;
}

SampleBlocks::SampleBlocks(const Eigen::MatrixXf& samples, const Eigen::RowVectorXf& subtracted)
    : samples_(static_cast<std::size_t>(samples.rows())),
      features_(static_cast<std::size_t>(samples.cols())),
      values_(blocks() * features_ * kRows) {
  for (std::size_t k = 0; k < features_; ++k) {
    const auto feature = static_cast<Eigen::Index>(k);
    for (std::size_t i = 0; i < samples_; ++i) {
      values_[(i / kRows * features_ + k) * kRows + i % kRows] =
          samples(static_cast<Eigen::Index>(i), feature) - subtracted[feature];
    }
  }
}

void SampleBlocks::multiply(std::size_t block, const PaddedRows& weights, PaddedRows& sums,
                            ProductSimd simd) const {
  kernels_for(simd).multiply(block_values(block), features_, weights, sums);
}

void SampleBlocks::add_transposed_product(std::size_t block, const PaddedRows& residuals,
                                          PaddedRows& sums, ProductSimd simd) const {
  kernels_for(simd).add_transposed(block_values(block), features_, residuals, sums);
}

}  // namespace roomwise::rooms
