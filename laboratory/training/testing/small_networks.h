#pragma once

#include <map>
#include <string>
#include <vector>

#include "roomwise/base/random.h"
#include "roomwise/network/graph/onnx_graph.h"

// Small networks for tests of training.
namespace roomwise::training::testing {

inline network::ConstantPointer random_constant(network::Shape shape, double size, double middle,
                                                std::uint64_t seed) {
  network::Constant constant;
  std::size_t count = 1;
  for (const std::int64_t length : shape) count *= static_cast<std::size_t>(length);
  constant.shape = std::move(shape);
  RandomStream random(seed);
  for (std::size_t i = 0; i < count; ++i)
    constant.floats.push_back(static_cast<float>(middle + size * random.normal()));
  return std::make_shared<const network::Constant>(std::move(constant));
}

inline network::Node node(const std::string& operation, std::vector<std::string> inputs,
                          const std::string& output,
                          const std::map<std::string, std::vector<std::int64_t>>& lists = {}) {
  network::Node made;
  made.name = output + "_node";
  made.operation = operation;
  made.inputs = std::move(inputs);
  made.outputs = {output};
  for (const auto& [name, integers] : lists) made.attributes[name] = network::Attribute(integers);
  return made;
}

// A convolution with stride 2, batch normalisation where asked for, and ReLU: "NAME_conv",
// "NAME_norm", "NAME".
inline void add_layer(network::OnnxGraph& graph, const std::string& name, const std::string& input,
                      std::int64_t inputs, std::int64_t outputs, bool normalised) {
  const auto put = [&](const std::string& what, network::Shape shape, double size, double middle) {
    graph.constants[name + what] =
        random_constant(std::move(shape), size, middle, graph.constants.size() + 7);
    return name + what;
  };
  graph.nodes.push_back(node(
      "Conv",
      {input, put("_weights", {outputs, inputs, 3, 3}, 0.2, 0), put("_bias", {outputs}, 0.1, 0)},
      name + "_conv", {{"strides", {2, 2}}, {"pads", {1, 1, 1, 1}}, {"kernel_shape", {3, 3}}}));
  if (normalised) {
    graph.nodes.push_back(
        node("BatchNormalization",
             {name + "_conv", put("_gain", {outputs}, 0.1, 1), put("_shift", {outputs}, 0.1, 0),
              put("_mean", {outputs}, 0.1, 0), put("_variance", {outputs}, 0.05, 1)},
             name + "_norm"));
  }
  graph.nodes.push_back(node("Relu", {name + (normalised ? "_norm" : "_conv")}, name));
}

// 3 x 16 x 16 to 12 features ("features", 1 x 12 x 1 x 1) and nothing else: two layers, "first" and
// "second".
inline network::OnnxGraph small_network(bool normalised = true) {
  network::OnnxGraph graph;
  graph.opset = 13;
  graph.inputs = {{"picture", {1, 3, 16, 16}}};
  add_layer(graph, "first", "picture", 3, 8, normalised);
  add_layer(graph, "second", "first", 8, 12, normalised);
  graph.nodes.push_back(node("GlobalAveragePool", {"second"}, "features"));
  graph.outputs = {"features"};
  return graph;
}

}  // namespace roomwise::training::testing
