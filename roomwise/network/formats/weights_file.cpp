#include "roomwise/network/formats/weights_file.h"

#include <algorithm>
#include <set>

#include "roomwise/network/formats/safetensors.h"
#include "roomwise/network/formats/torch_checkpoint_reader.h"
#include "roomwise/network/graph/graph_builder.h"

namespace roomwise::network {
namespace {

bool is_for_training(const std::string& name) {
  return name.ends_with(".num_batches_tracked") || name.starts_with("AuxLogits.");
}

}  // namespace

Expected<Weights> read_weights(std::span<const std::uint8_t> bytes) {
  if (is_torch_checkpoint(bytes)) return read_torch_checkpoint(bytes);
  if (is_safetensors(bytes)) return read_safetensors(bytes);
  ROOMWISE_TRY(OnnxGraph graph, read_onnx_graph(bytes).map_error([](Error error) {
    return Error{"is neither a PyTorch checkpoint nor a safetensors file, and " + error.message};
  }));
  return std::move(graph.constants);
}

Expected<void> apply_weights(OnnxGraph& graph, const Weights& weights) {
  const std::vector<std::string> parameters = parameters_of(graph);
  std::vector<std::string> wrong;
  for (const std::string& name : parameters) {
    const Shape& wanted = graph.constants.at(name)->shape;
    const auto found = weights.find(name);
    if (found == weights.end()) {
      wrong.push_back(fmt::format("\"{}\" is missing", name));
    } else if (found->second->is_integer || found->second->shape != wanted) {
      wrong.push_back(fmt::format("\"{}\" is {}{} instead of {}", name,
                                  found->second->is_integer ? "whole numbers, " : "",
                                  shape_text(found->second->shape), shape_text(wanted)));
    }
  }
  const std::set<std::string> wanted(parameters.begin(), parameters.end());
  for (const auto& [name, tensor] : weights) {
    // An ONNX file's limits and rates are constants of both.
    if (!wanted.contains(name) && !is_for_training(name) && !graph.constants.contains(name))
      wrong.push_back(fmt::format("\"{}\" has no place in the network", name));
  }
  if (!wrong.empty()) return fail("its tensors do not fit the network: {}", fmt::join(wrong, "; "));
  for (const std::string& name : parameters) graph.constants[name] = weights.at(name);
  return {};
}

}  // namespace roomwise::network
