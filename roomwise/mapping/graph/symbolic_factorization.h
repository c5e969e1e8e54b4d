#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace roomwise::mapping {

// A place off the diagonal of a symmetric matrix of blocks; (a, b) and (b, a) are the same.
using BlockPair = std::pair<std::uint32_t, std::uint32_t>;

// Neighbouring columns of a Cholesky factor that are eliminated together. What they leave goes to
// one other such front, which is why the method is called multifrontal (Duff and Reid 1983).
struct Front {
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  std::uint32_t columns = 0;  // eliminated here: the first so many of its rows
  std::uint32_t parent = kNone;
  std::vector<std::uint32_t> rows;  // block rows that are not zero, ascending, in elimination order
};

// In which order the blocks of a symmetric matrix are eliminated so that few zeros fill up
// (approximate minimum degree), and in which fronts.
struct SymbolicFactorization {
  std::vector<std::uint32_t> place;  // of each block in the order of elimination
  std::vector<Front> fronts;         // children before parents, the last child next to its parent
};

// Of a matrix of count x count blocks whose diagonal blocks and those of `pairs` are not zero. A
// pair may be given more than once. The same pairs in the same order give the same result.
[[nodiscard]] SymbolicFactorization analyze_pattern(std::size_t count,
                                                    std::span<const BlockPair> pairs);

}  // namespace roomwise::mapping
