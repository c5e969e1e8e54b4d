#pragma once

#include <cstdint>

namespace roomwise::network {

// TensorProto.DataType of ONNX files, as far as it is read and written.
enum class TensorType : std::int64_t {
  kFloat = 1,
  kInt32 = 6,
  kInt64 = 7,
  kBool = 9,
  kFloat16 = 10,
  kDouble = 11,
  kBrainFloat16 = 16
};

}  // namespace roomwise::network
