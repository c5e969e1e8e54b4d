#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "roomwise/base/simd.h"

namespace roomwise::rooms {

// Rows of numbers, each a multiple of eight, the rest zeros.
struct PaddedRows {
  PaddedRows(std::size_t rows, std::size_t used_columns)
      : columns((used_columns + 7) / 8 * 8), values(rows * columns) {}
  [[nodiscard]] float* row(std::size_t i) { return values.data() + i * columns; }
  [[nodiscard]] const float* row(std::size_t i) const { return values.data() + i * columns; }

  std::size_t columns = 0;
  std::vector<float> values;
};

// Instructions that the products can be computed with; each kind gives the same bits.
enum class ProductSimd { kPortable, kAvx2, kAvx512 };
[[nodiscard]] bool is_supported(ProductSimd simd);
// What this process computes them with: where it may use AVX2 (process_simd()), the widest that the
// processor has.
[[nodiscard]] ProductSimd process_product_simd();

// Samples (one a row, float) in blocks of 32 with the rows of a block beside each other, as the two
// products that learning takes read them. Each sum is taken in one order, by multiplications and
// additions that are rounded one by one: the same bits by any instructions.
class SampleBlocks {
 public:
  static constexpr std::size_t kRows = 32;

  // What is subtracted from every sample: one number a feature.
  SampleBlocks(const Eigen::MatrixXf& samples, const Eigen::RowVectorXf& subtracted);

  [[nodiscard]] std::size_t samples() const { return samples_; }
  [[nodiscard]] std::size_t features() const { return features_; }
  [[nodiscard]] std::size_t blocks() const { return (samples_ + kRows - 1) / kRows; }

  // The samples of a block times weights (features x columns): sums becomes kRows x columns.
  void multiply(std::size_t block, const PaddedRows& weights, PaddedRows& sums,
                ProductSimd simd = process_product_simd()) const;
  // Adds the transposed samples of a block times residuals (kRows x columns) to sums (features x
  // columns). Rows after the last sample count as zeros.
  void add_transposed_product(std::size_t block, const PaddedRows& residuals, PaddedRows& sums,
                              ProductSimd simd = process_product_simd()) const;

 private:
  [[nodiscard]] const float* block_values(std::size_t block) const {
    return values_.data() + block * features_ * kRows;
  }
  std::size_t samples_ = 0;
  std::size_t features_ = 0;
  std::vector<float> values_;  // block by block, feature by feature, row by row
};

}  // namespace roomwise::rooms
