#pragma once

#include <functional>
#include <span>
#include <vector>

#include "roomwise/network/graph/program.h"

namespace roomwise::network {

// Work that oneDNN has no primitive for, or a slow one.

// Reads the inputs and writes the output, all as the kernel was made to expect them. Fails where
// what the inputs hold cannot be worked on.
using Kernel = std::function<Expected<void>(std::span<const float* const> inputs, float* output)>;

// Values are batch x channels x places, the channels in blocks of `block` that lie side by side at
// each place (1: row by row); the last block is filled up with zeros.
struct BlockedShape {
  std::size_t outer = 1;
  std::size_t channels = 1;
  std::size_t inner = 1;
  std::size_t block = 1;

  // `shape` around an axis.
  [[nodiscard]] static BlockedShape around(const Shape& shape, std::size_t axis,
                                           std::size_t block = 1);
  [[nodiscard]] std::size_t blocks() const { return (channels + block - 1) / block; }
};

// inputs: the shapes that the gather's slices come from, of one block.
[[nodiscard]] Kernel gather_kernel(const AxisSlices& gather, std::vector<BlockedShape> inputs,
                                   const BlockedShape& output);
// From `shape` (batch x channels x height x width), in blocks of `block`.
[[nodiscard]] Kernel resampling_kernel(const Resampling& resampling, const Shape& shape,
                                       std::size_t block);
// The rest of the kernels take and give values row by row.
[[nodiscard]] Kernel arithmetic_kernel(Arithmetic::Operator operation, const Shape& a,
                                       const Shape& b, const Shape& output);
[[nodiscard]] Kernel mean_kernel(const Mean& mean, const Shape& shape);
[[nodiscard]] Kernel erf_kernel(const Shape& shape);
[[nodiscard]] Kernel selection_kernel(const Shape& condition, const Shape& a, const Shape& b,
                                      const Shape& output);
// Of a table of `shape`, `count` slices. Its errors name the node.
[[nodiscard]] Kernel lookup_kernel(const Gather& lookup, const Shape& shape, std::size_t count,
                                   const std::string& node);
[[nodiscard]] Kernel largest_index_kernel(const ArgMax& largest, const Shape& shape);

}  // namespace roomwise::network
