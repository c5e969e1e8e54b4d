#include "roomwise/mapping/graph/block_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>

#include "roomwise/base/random.h"

namespace roomwise::mapping {
namespace {

using geometry::Matrix6d;

// A random symmetric matrix of blocks, positive definite since its diagonal outweighs the rest.
struct BlockMatrix {
  std::vector<BlockPair> pairs;
  std::vector<Matrix6d> diagonal;
  std::vector<Matrix6d> off_diagonal;

  [[nodiscard]] Eigen::MatrixXd dense() const {
    const auto size = 6 * static_cast<Eigen::Index>(diagonal.size());
    Eigen::MatrixXd whole = Eigen::MatrixXd::Zero(size, size);
    for (std::size_t i = 0; i < diagonal.size(); ++i) {
      const auto at = 6 * static_cast<Eigen::Index>(i);
      whole.block<6, 6>(at, at) = diagonal[i];
    }
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const auto a = 6 * static_cast<Eigen::Index>(pairs[i].first);
      const auto b = 6 * static_cast<Eigen::Index>(pairs[i].second);
      whole.block<6, 6>(a, b) += off_diagonal[i];
      whole.block<6, 6>(b, a) += off_diagonal[i].transpose();
    }
    return whole;
  }
};

Matrix6d random_block(RandomStream& random) {
  Matrix6d block;
  for (double& number : block.reshaped()) number = random.normal();
  return block;
}

BlockMatrix random_matrix(RandomStream& random, std::size_t count, std::vector<BlockPair> pairs) {
  BlockMatrix matrix{std::move(pairs), std::vector<Matrix6d>(count), {}};
  for (Matrix6d& block : matrix.diagonal) {
    const Matrix6d any = random_block(random);
    block = any * any.transpose() + Matrix6d::Identity();
  }
  for (const auto& [a, b] : matrix.pairs) {
    const Matrix6d block = matrix.off_diagonal.emplace_back(random_block(random));
    matrix.diagonal[a] += 10 * block.norm() * Matrix6d::Identity();
    matrix.diagonal[b] += 10 * block.norm() * Matrix6d::Identity();
  }
  return matrix;
}

// A walk with random links, some of them twice and backwards.
std::vector<BlockPair> walk_with_links(RandomStream& random, std::uint32_t count,
                                       std::size_t links) {
  std::vector<BlockPair> pairs;
  for (std::uint32_t i = 1; i < count; ++i) pairs.emplace_back(i - 1, i);
  while (count > 1 && links > 0) {
    const auto a = static_cast<std::uint32_t>(random.index(count));
    const auto b = static_cast<std::uint32_t>(random.index(count));
    if (a == b) continue;
    pairs.emplace_back(a, b);
    if (links % 3 == 0) pairs.emplace_back(b, a);
    --links;
  }
  return pairs;
}

void expect_solves(const BlockMatrix& matrix, RandomStream& random) {
  BlockCholesky cholesky(matrix.diagonal.size(), matrix.pairs);
  const Eigen::MatrixXd dense = matrix.dense();
  for (int round = 0; round < 2; ++round) {  // the second uses memory of the first again
    ASSERT_TRUE(cholesky.factorize(matrix.diagonal, matrix.off_diagonal));
    Eigen::VectorXd b(dense.rows());
    for (double& number : b) number = random.normal();
    Eigen::VectorXd x = b;
    cholesky.solve(x);
    EXPECT_LT((dense * x - b).norm(), 1e-12 * b.norm());
    EXPECT_LT((x - dense.llt().solve(b)).norm(), 1e-12 * x.norm());
  }
}

TEST(BlockCholesky, SolvesAsADenseFactorisationDoes) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    RandomStream random(seed);
    const auto count = static_cast<std::uint32_t>(1 + random.index(40));
    const auto pairs = walk_with_links(random, count, random.index(60));
    expect_solves(random_matrix(random, count, pairs), random);
  }
}

TEST(BlockCholesky, SolvesMatricesOfSeveralParts) {
  RandomStream random(5);
  expect_solves(random_matrix(random, 5, {}), random);
  expect_solves(random_matrix(random, 9, {{0, 3}, {7, 5}, {5, 2}, {8, 7}}), random);
}

TEST(BlockCholesky, SolvesAFullMatrixAndAStar) {
  RandomStream random(6);
  std::vector<BlockPair> full;
  std::vector<BlockPair> star;
  for (std::uint32_t i = 0; i < 12; ++i) {
    for (std::uint32_t k = 0; k < i; ++k) full.emplace_back(i, k);
    if (i != 4) star.emplace_back(4, i);
  }
  expect_solves(random_matrix(random, 12, full), random);
  expect_solves(random_matrix(random, 12, star), random);
}

TEST(BlockCholesky, SaysWhereAMatrixIsNotPositiveDefinite) {
  RandomStream random(7);
  BlockMatrix matrix = random_matrix(random, 10, walk_with_links(random, 10, 8));
  BlockCholesky cholesky(10, matrix.pairs);
  ASSERT_TRUE(cholesky.factorize(matrix.diagonal, matrix.off_diagonal));
  const BlockMatrix good = matrix;
  for (const double bad : {-1.0, 0.0, std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity()}) {
    matrix.diagonal[6](3, 3) = bad;
    EXPECT_FALSE(cholesky.factorize(matrix.diagonal, matrix.off_diagonal)) << bad;
  }
  EXPECT_TRUE(cholesky.factorize(good.diagonal, good.off_diagonal));
}

TEST(PlanElimination, EliminatesEachBlockOnceAndChildrenBeforeParents) {
  RandomStream random(8);
  const std::uint32_t count = 200;
  const auto pairs = walk_with_links(random, count, 60);
  const SymbolicFactorization plan = analyze_pattern(count, pairs);
  std::vector<std::uint32_t> places = plan.place;
  std::ranges::sort(places);
  std::uint32_t next = 0;
  for (std::uint32_t i = 0; i < count; ++i) EXPECT_EQ(places[i], i);
  for (std::size_t i = 0; i < plan.fronts.size(); ++i) {
    const Front& front = plan.fronts[i];
    for (std::size_t k = 0; k < front.columns; ++k) EXPECT_EQ(front.rows[k], next++);
    EXPECT_TRUE(std::ranges::is_sorted(front.rows));
    if (front.rows.size() == front.columns) {
      EXPECT_EQ(front.parent, Front::kNone);
      continue;
    }
    ASSERT_GT(front.parent, i);
    ASSERT_LT(front.parent, plan.fronts.size());
    EXPECT_TRUE(std::includes(plan.fronts[front.parent].rows.begin(),
                              plan.fronts[front.parent].rows.end(),
                              front.rows.begin() + front.columns, front.rows.end()));
  }
  EXPECT_EQ(next, count);
}

TEST(PlanElimination, FillsUpNoMoreThanAGoodOrderMust) {
  // A grid of 30 x 30: nested dissection gives 31/4 n log2 n non-zeros for n = 30^2 (George 1973),
  // row by row 30^3. Minimum degree must be near the former.
  const std::uint32_t side = 30;
  std::vector<BlockPair> pairs;
  for (std::uint32_t y = 0; y < side; ++y) {
    for (std::uint32_t x = 0; x < side; ++x) {
      if (x > 0) pairs.emplace_back(y * side + x - 1, y * side + x);
      if (y > 0) pairs.emplace_back((y - 1) * side + x, y * side + x);
    }
  }
  std::size_t stored = 0;
  for (const Front& front : analyze_pattern(side * side, pairs).fronts) {
    for (std::size_t k = 0; k < front.columns; ++k) stored += front.rows.size() - k;
  }
  EXPECT_LT(stored, 15000U);
}

}  // namespace
}  // namespace roomwise::mapping
