#pragma once

#include <ATen/core/Tensor.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "roomwise/network/graph/onnx_graph.h"

// ONNX's operators by libtorch, so that gradients go through them.
namespace roomwise::training {

using Values = std::vector<at::Tensor>;

// What a node does: its inputs (undefined where one is left out) to its outputs. `learning` says
// that batch normalisation goes by the batch's own statistics and updates the running ones. Throws
// libtorch's errors where inputs do not fit.
using Operation = std::function<Values(const Values& inputs, bool learning)>;
using MakeOperation = Expected<Operation> (*)(const network::Node& node, std::int64_t opset);
using OperatorTable = std::map<std::string, MakeOperation>;

// Fails where the operator, or a variant of it that the node asks for, is not supported.
[[nodiscard]] Expected<Operation> make_operation(const network::Node& node, std::int64_t opset);

// Convolutions, pooling, batch normalisation, products, element-wise functions.
[[nodiscard]] const OperatorTable& layer_operators();
// Reshape for values that do not hang on the network's input: their first size is no batch.
[[nodiscard]] Operation reshape_of_constant();

// What moves, reshapes and slices values.
[[nodiscard]] const OperatorTable& shape_operators();

// Whole numbers of a small tensor.
[[nodiscard]] std::vector<std::int64_t> integers_of(const at::Tensor& tensor);

}  // namespace roomwise::training
