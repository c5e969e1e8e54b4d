#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "roomwise/network/graph/onnx_graph.h"

namespace roomwise::network {

// How files write numbers down, little end first; as TensorProto.DataType of ONNX files counts.
enum class NumberFormat : std::int64_t {
  kFloat = 1,
  kInteger32 = 6,
  kInteger64 = 7,
  kBool = 9,
  kHalf = 10,
  kDouble = 11,
  kBfloat16 = 16
};

// A format and what other files call it.
struct NumberFormatNames {
  NumberFormat format;
  std::size_t bytes;
  std::string_view torch_storage;
  std::string_view safetensors;  // empty: not understood there
};
[[nodiscard]] std::span<const NumberFormatNames> number_formats();

[[nodiscard]] std::size_t bytes_of(NumberFormat format);
[[nodiscard]] bool is_integer(NumberFormat format);

// The numbers of `bytes`: floats, or integers of the whole kinds. Bytes beyond the last whole
// number are left.
[[nodiscard]] Constant numbers_from(NumberFormat format, std::span<const std::uint8_t> bytes);

// How many values a tensor of this shape has; absent where a size is negative or there are more
// than any network needs (2^30).
[[nodiscard]] std::optional<std::size_t> values_of(const Shape& shape);

}  // namespace roomwise::network
