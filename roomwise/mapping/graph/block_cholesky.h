#pragma once

#include <span>
#include <vector>

#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/mapping/graph/symbolic_factorization.h"

namespace roomwise::mapping {

// Solves A x = b for symmetric positive definite matrices A of 6 x 6 blocks with the same blocks
// not zero: multifrontal Cholesky factorisation. Runs on one thread and calls no BLAS, so that the
// bits depend neither on threads nor on the BLAS that a machine has.
class BlockCholesky {
 public:
  // Plans the elimination once for all matrices; see analyze_pattern().
  BlockCholesky(std::size_t count, std::vector<BlockPair> pairs);

  // `diagonal` by block, of which the lower triangles are read; `off_diagonal` in the order of the
  // pairs (a, b), with rows of a and columns of b; blocks of the same pair add up. False where A is
  // not positive definite (or not finite) in double precision.
  [[nodiscard]] bool factorize(std::span<const geometry::Matrix6d> diagonal,
                               std::span<const geometry::Matrix6d> off_diagonal);

  // After factorize() said true. `x` holds b before and A^-1 b after, six numbers a block.
  void solve(Eigen::VectorXd& x) const;

 private:
  // Where an off-diagonal block goes: it is taken transposed where a comes before b.
  struct Entry {
    std::size_t pair = 0;
    std::uint32_t row = 0;
    std::uint32_t column = 0;
    bool transposed = false;
  };

  std::vector<BlockPair> pairs_;
  SymbolicFactorization symbolic_;
  std::vector<std::size_t> block_at_;                 // by place in the order of elimination
  std::vector<std::vector<Entry>> entries_;           // by front
  std::vector<std::vector<std::uint32_t>> children_;  // by front
  // By front: its columns of the factor, column-major, the rows padded as the kernels want them.
  std::vector<std::vector<double>> panels_;
  // Memory for what fronts leave to their parents, kept from one factorisation to the next.
  std::vector<std::vector<double>> spare_;
};

// Adds damping D to the diagonal blocks (see geometry::damping_weights()), and gives it.
Eigen::VectorXd add_damping(std::span<geometry::Matrix6d> diagonal, double damping);

}  // namespace roomwise::mapping
