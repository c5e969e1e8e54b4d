#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "roomwise/base/expected.h"

namespace roomwise::network {

// What an ONNX network asks for.
struct OnnxInput {
  static constexpr std::int64_t kFree = -1;  // a size that the file leaves open

  std::string name;
  std::vector<std::int64_t> shape;
};

// The inputs that an ONNX file declares, without those that it fills itself (weights). Fails where
// the bytes are no ONNX file or end too early. (OpenCV reads the network but does not tell what it
// takes, and runs it on anything.)
[[nodiscard]] Expected<std::vector<OnnxInput>> read_onnx_inputs(std::span<const std::uint8_t> onnx);

}  // namespace roomwise::network
