#pragma once

#include <span>

#include "roomwise/network/graph/program.h"

namespace roomwise::network {

// Arithmetic on what a graph knows beforehand: shapes, indices, weights.

// The slices `indices` along an axis.
[[nodiscard]] Constant pick(const Constant& constant, std::size_t axis,
                            std::span<const std::size_t> indices);
// One after the other along an axis; all of one type and alike in the other sizes.
[[nodiscard]] Constant join(std::span<const ConstantPointer> parts, std::size_t axis);
[[nodiscard]] Constant permute(const Constant& constant, std::span<const std::size_t> axes);
// Of two constants of one type that broadcast; comparisons give whole numbers. Fails on whole
// numbers divided by zero.
[[nodiscard]] Expected<Constant> compute(Arithmetic::Operator operation, const Constant& a,
                                         const Constant& b);
// `a` where the condition (whole numbers) is not 0, else `b`; all broadcast.
[[nodiscard]] Expected<Constant> select(const Constant& condition, const Constant& a,
                                        const Constant& b);

inline float apply(Arithmetic::Operator operation, float a, float b) {
  switch (operation) {
    case Arithmetic::Operator::kAdd:
      return a + b;
    case Arithmetic::Operator::kSubtract:
      return a - b;
    case Arithmetic::Operator::kMultiply:
      return a * b;
    case Arithmetic::Operator::kDivide:
      return a / b;
    case Arithmetic::Operator::kMaximum:
      return a < b ? b : a;
    case Arithmetic::Operator::kMinimum:
      return b < a ? b : a;
    case Arithmetic::Operator::kEqual:
      return a == b ? 1.F : 0.F;
    case Arithmetic::Operator::kLess:
      return a < b ? 1.F : 0.F;
  }
  return 0;
}

// For every place of `shape`, row by row, the place in a tensor of `strides` (0: broadcast).
[[nodiscard]] std::vector<std::size_t> offsets(const Shape& shape,
                                               std::span<const std::size_t> strides);
// How far apart neighbours along each axis lie, row by row; 0 where `shape` has the size 1 and
// `target` (of at least as many axes) has not.
[[nodiscard]] std::vector<std::size_t> broadcast_strides(const Shape& shape, const Shape& target);

}  // namespace roomwise::network
