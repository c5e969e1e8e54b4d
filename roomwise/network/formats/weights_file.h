#pragma once

#include <filesystem>

#include "roomwise/base/file.h"
#include "roomwise/network/graph/onnx_graph.h"

namespace roomwise::network {

// Tensors by name.
using Weights = std::map<std::string, ConstantPointer>;

// The tensors of a file: PyTorch's checkpoints (torch_checkpoint_reader.h), safetensors
// (safetensors.h), or an ONNX file's initializers; which of them it is, its first bytes say.
[[nodiscard]] Expected<Weights> read_weights(std::span<const std::uint8_t> bytes);

// Puts the weights in the place of the graph's parameters of the same names. Fails, and changes
// nothing, where a parameter has no tensor, a tensor no parameter, or one has another shape, naming
// them all. Left out are what only training needs: NAME.num_batches_tracked, and the auxiliary head
// (AuxLogits.NAME) where the graph has none.
[[nodiscard]] Expected<void> apply_weights(OnnxGraph& graph, const Weights& weights);

}  // namespace roomwise::network
