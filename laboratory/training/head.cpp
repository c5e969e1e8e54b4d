#include "laboratory/training/head.h"

#include <algorithm>
#include <optional>
#include <set>

#include "roomwise/base/random.h"
#include "roomwise/network/graph/lowering.h"

namespace roomwise::training {
namespace {

// Nodes and numbers that the outputs do not hang on.
void drop_unneeded(network::OnnxGraph& graph) {
  std::set<std::string> needed(graph.outputs.begin(), graph.outputs.end());
  const auto wanted = [&](const std::string& value) { return needed.contains(value); };
  std::vector<network::Node> kept;
  for (auto node = graph.nodes.rbegin(); node != graph.nodes.rend(); ++node) {
    if (!std::ranges::any_of(node->outputs, wanted)) continue;
    needed.insert(node->inputs.begin(), node->inputs.end());
    kept.push_back(std::move(*node));
  }
  std::ranges::reverse(kept);
  graph.nodes = std::move(kept);
  std::erase_if(graph.constants, [&](const auto& entry) { return !needed.contains(entry.first); });
  std::erase_if(graph.output_shapes,
                [&](const auto& entry) { return !needed.contains(entry.first); });
}

// The value that `name` means: itself, or the first output of the node of that name.
Expected<std::string> value_named(const network::OnnxGraph& graph, const std::string& name) {
  const network::Node* named = nullptr;
  for (const network::Node& node : graph.nodes) {
    if (std::ranges::find(node.outputs, name) != node.outputs.end()) return name;
    if (node.name == name && named == nullptr && !node.outputs.empty()) named = &node;
  }
  if (named == nullptr)
    return fail("the network has no output or node named \"{}\" that could be its features", name);
  return named->outputs.front();
}

// No value or constant is called so yet.
std::string unused(const network::OnnxGraph& graph, std::string name) {
  const auto taken = [&] {
    return graph.constants.contains(name) ||
           std::ranges::any_of(graph.nodes, [&](const network::Node& node) {
             return node.name == name ||
                    std::ranges::find(node.outputs, name) != node.outputs.end();
           });
  };
  while (taken()) name += "_";
  return name;
}

std::string add_node(network::OnnxGraph& graph, const std::string& operation,
                     std::vector<std::string> inputs, const std::string& output) {
  network::Node node;
  node.operation = operation;
  node.inputs = std::move(inputs);
  node.name = node.outputs.emplace_back(unused(graph, output));
  graph.nodes.push_back(std::move(node));
  return graph.nodes.back().name;
}

std::string add_constant(network::OnnxGraph& graph, const std::string& name, network::Shape shape,
                         std::vector<float> values) {
  std::string added = unused(graph, name);
  graph.constants[added] = std::make_shared<const network::Constant>(
      network::Constant{std::move(shape), false, std::move(values), {}});
  return added;
}

// The shape of a value for one picture.
Expected<network::Shape> shape_of(const network::OnnxGraph& graph, const std::string& value) {
  std::vector<network::Shape> inputs;
  for (const network::GraphInput& input : graph.inputs) {
    inputs.push_back(input.shape);
    if (!inputs.back().empty()) inputs.back().front() = 1;
  }
  const std::vector<std::string> outputs{value};
  ROOMWISE_TRY(const network::Program program, network::lower(graph, inputs, outputs));
  return program.values[program.outputs.front()].shape;
}

// What the last layer of the second head is given, where there is one.
std::optional<std::string> input_of_aux_head(const network::OnnxGraph& graph) {
  for (const network::Node& node : graph.nodes) {
    if (node.operation != "Gemm" || node.outputs.empty()) continue;
    const std::string& name = node.outputs.front();
    if (std::ranges::find(graph.outputs, name) == graph.outputs.end()) continue;
    if (name.starts_with("aux") || name.starts_with("Aux")) return node.inputs.front();
  }
  return std::nullopt;
}

// A Gemm of `outputs` on a list of `inputs` numbers.
std::string add_linear(network::OnnxGraph& graph, const std::string& from, const std::string& name,
                       std::int64_t inputs, std::size_t outputs, RandomStream random) {
  constexpr double kSpread = 0.01;
  const auto rows = static_cast<std::int64_t>(outputs);
  std::vector<float> weights(static_cast<std::size_t>(inputs) * outputs);
  for (float& weight : weights) weight = static_cast<float>(kSpread * random.normal());
  const std::string of_weights =
      add_constant(graph, name + ".weight", {rows, inputs}, std::move(weights));
  const std::string of_biases =
      add_constant(graph, name + ".bias", {rows}, std::vector<float>(outputs, 0.0F));
  const std::string added = add_node(graph, "Gemm", {from, of_weights, of_biases}, name);
  graph.nodes.back().attributes["transB"] = network::Attribute(std::int64_t{1});
  return added;
}

}  // namespace

network::OnnxGraph reduced_to(network::OnnxGraph graph, const std::string& output) {
  graph.outputs = {output};
  drop_unneeded(graph);
  return graph;
}

Expected<NewHead> with_new_head(network::OnnxGraph graph, const std::string& features,
                                std::size_t classes, std::uint64_t seed) {
  ROOMWISE_TRY(std::string value, value_named(graph, features));
  const std::optional<std::string> aux = input_of_aux_head(graph);
  graph.outputs = {value};
  if (aux) graph.outputs.push_back(*aux);
  drop_unneeded(graph);
  ROOMWISE_TRY(const network::Shape shape, shape_of(graph, value));
  if (shape.size() != 2 && shape.size() != 4)
    return fail("the features \"{}\" have the shape {}; a list or maps are understood", features,
                network::shape_text(shape));
  const bool is_map = shape.size() == 4 && shape[2] * shape[3] > 1;
  if (is_map) value = add_node(graph, "GlobalAveragePool", {value}, "head_pool");
  if (shape.size() == 4) value = add_node(graph, "Flatten", {value}, "head_features");
  NewHead head;
  head.logits = add_linear(graph, value, "logits", shape[1], classes, RandomStream(seed, {0}));
  graph.outputs = {head.logits};
  if (aux) {
    ROOMWISE_TRY(const network::Shape of_aux, shape_of(graph, *aux));
    head.aux_logits =
        add_linear(graph, *aux, "aux_logits", of_aux[1], classes, RandomStream(seed, {1}));
    graph.outputs.push_back(head.aux_logits);
  }
  head.graph = std::move(graph);
  return head;
}

std::string before_softmax(const network::OnnxGraph& graph, const std::string& value) {
  for (const network::Node& node : graph.nodes) {
    if (node.operation == "Softmax" && !node.outputs.empty() && node.outputs.front() == value)
      return node.inputs.front();
  }
  return value;
}

}  // namespace roomwise::training
