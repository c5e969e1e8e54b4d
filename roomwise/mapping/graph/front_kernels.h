#pragma once

#include <cstddef>

namespace roomwise::mapping {

// Blocks are 6 x 6; columns of a front are stored one after the other, `stride` numbers apart.
inline constexpr std::size_t kBlock = 6;

// Numbers of which a column's part below the eliminated blocks holds a multiple.
inline constexpr std::size_t kLane = 8;
constexpr std::size_t padded(std::size_t rows) {
  return (rows + kLane - 1) / kLane * kLane;
}

// A panel: the block columns that a front eliminates, rows stored from the first of them on and
// `stride` = kBlock * columns + padded(rows below) numbers each.
struct Panel {
  double* numbers = nullptr;
  std::size_t columns = 0;  // blocks
  std::size_t stride = 0;
};

// Replaces the lower triangle of the panel's columns by the Cholesky factor's. False where a
// pivot is not positive.
[[nodiscard]] bool eliminate(const Panel& panel);

// Adds to the lower triangle of a square matrix of the rows below, stored with stride
// padded(kBlock * blocks), what the panel's elimination leaves: minus L L^T of those rows.
void subtract_products(const Panel& panel, std::size_t blocks, double* left);

}  // namespace roomwise::mapping
