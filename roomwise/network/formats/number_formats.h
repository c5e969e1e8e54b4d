#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "roomwise/network/graph/onnx_graph.h"

namespace roomwise::network {

// How files of weights write numbers down, little end first.
enum class NumberFormat { kFloat, kHalf, kBfloat16, kDouble, kInteger32, kInteger64, kBool };

[[nodiscard]] std::size_t bytes_of(NumberFormat format);

// The numbers of `bytes`: floats, or integers of the whole kinds. Bytes beyond the last whole
// number are left.
[[nodiscard]] Constant numbers_from(NumberFormat format, std::span<const std::uint8_t> bytes);

// How many values a tensor of this shape has; absent where a size is negative or there are more
// than any network needs (2^30).
[[nodiscard]] std::optional<std::size_t> values_of(const Shape& shape);

}  // namespace roomwise::network
