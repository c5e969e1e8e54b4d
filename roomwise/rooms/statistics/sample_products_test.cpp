#include "roomwise/rooms/statistics/sample_products.h"

#include <gmock/gmock.h>

#include "roomwise/base/random.h"

namespace roomwise::rooms {
namespace {

Eigen::MatrixXf random_matrix(Eigen::Index rows, Eigen::Index columns, std::uint64_t seed) {
  RandomStream random(seed);
  Eigen::MatrixXf matrix(rows, columns);
  for (float& value : matrix.reshaped()) value = static_cast<float>(random.normal());
  return matrix;
}

PaddedRows padded(const Eigen::MatrixXf& matrix) {
  PaddedRows rows(static_cast<std::size_t>(matrix.rows()), static_cast<std::size_t>(matrix.cols()));
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) {
      rows.row(static_cast<std::size_t>(i))[j] = matrix(i, j);
    }
  }
  return rows;
}

// Sizes with and without a rest: samples, features, columns.
class Products : public ::testing::TestWithParam<std::array<Eigen::Index, 3>> {};

TEST_P(Products, AreThoseOfMatrices) {
  const auto [count, features, columns] = GetParam();
  const Eigen::MatrixXf samples = random_matrix(count, features, 1);
  const Eigen::RowVectorXf mean = samples.colwise().mean();
  const SampleBlocks blocks(samples, mean);
  const Eigen::MatrixXf weights = random_matrix(features, columns, 2);
  const Eigen::MatrixXf residuals = random_matrix(SampleBlocks::kRows, columns, 3);
  const Eigen::MatrixXf centred = samples.rowwise() - mean;
  for (std::size_t block = 0; block < blocks.blocks(); ++block) {
    const auto first = static_cast<Eigen::Index>(block * SampleBlocks::kRows);
    const auto rows = std::min<Eigen::Index>(SampleBlocks::kRows, count - first);
    const Eigen::MatrixXf part = centred.middleRows(first, rows);
    const Eigen::MatrixXf logits = part * weights;
    const Eigen::MatrixXf transposed = part.transpose() * residuals.topRows(rows);
    PaddedRows found(SampleBlocks::kRows, static_cast<std::size_t>(columns));
    PaddedRows sums = padded(Eigen::MatrixXf::Ones(features, columns));
    blocks.multiply(block, padded(weights), found);
    blocks.add_transposed_product(block, padded(residuals), sums);
    for (Eigen::Index j = 0; j < columns; ++j) {
      for (Eigen::Index i = 0; i < rows; ++i) {
        EXPECT_NEAR(found.row(static_cast<std::size_t>(i))[j], logits(i, j), 1e-3);
      }
      for (Eigen::Index k = 0; k < features; ++k) {
        EXPECT_NEAR(sums.row(static_cast<std::size_t>(k))[j], 1 + transposed(k, j), 1e-3);
      }
    }
  }
}

TEST_P(Products, HaveTheSameBitsByAnyInstructions) {
  const auto [count, features, columns] = GetParam();
  const SampleBlocks blocks(random_matrix(count, features, 1), Eigen::RowVectorXf::Zero(features));
  const PaddedRows weights = padded(random_matrix(features, columns, 2));
  std::vector<std::vector<float>> found;
  for (const auto simd : {ProductSimd::kPortable, ProductSimd::kAvx2, ProductSimd::kAvx512}) {
    if (!is_supported(simd)) continue;
    PaddedRows logits(SampleBlocks::kRows, static_cast<std::size_t>(columns));
    PaddedRows sums(static_cast<std::size_t>(features), static_cast<std::size_t>(columns));
    blocks.multiply(0, weights, logits, simd);
    blocks.add_transposed_product(0, logits, sums, simd);
    found.push_back(sums.values);
  }
  if (found.size() == 1) GTEST_SKIP() << "neither AVX2 nor AVX-512: nothing to compare";
  EXPECT_THAT(found, ::testing::Each(found.front()));
}

INSTANTIATE_TEST_SUITE_P(Sizes, Products,
                         ::testing::Values(std::array<Eigen::Index, 3>{1, 1, 1},
                                           std::array<Eigen::Index, 3>{32, 128, 16},
                                           std::array<Eigen::Index, 3>{70, 301, 15},
                                           std::array<Eigen::Index, 3>{33, 6, 40}));

}  // namespace
}  // namespace roomwise::rooms
