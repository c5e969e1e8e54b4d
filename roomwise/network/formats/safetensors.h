#pragma once

#include "roomwise/network/formats/weights_file.h"

namespace roomwise::network {

// The safetensors format (https://github.com/huggingface/safetensors): the size of a header, the
// header (JSON: name, type, shape and place of each tensor), the numbers.

[[nodiscard]] bool is_safetensors(std::span<const std::uint8_t> bytes);

// Floats of 16, 32 and 64 bits, bfloat16, and whole numbers of 32 and 64 bits. Fails where the
// header is no such JSON, or a tensor (named) is not as large as its shape, overlaps another or
// lies beyond the file's end.
[[nodiscard]] Expected<Weights> read_safetensors(std::span<const std::uint8_t> bytes);

// 32-bit floats and 64-bit integers. Same weights, same bytes.
[[nodiscard]] Bytes write_safetensors(const Weights& weights);

}  // namespace roomwise::network
