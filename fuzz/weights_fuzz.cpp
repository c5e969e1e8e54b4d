// Any bytes as a file of weights: PyTorch's checkpoints, safetensors, ONNX.

#include <span>

#include "fuzz_target.h"
#include "roomwise/network/formats/weights_file.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto weights = roomwise::network::read_weights(std::span(data, size));
  if (!weights && weights.error().message.empty()) __builtin_trap();
  return 0;
}
