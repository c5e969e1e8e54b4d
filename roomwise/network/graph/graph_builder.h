#pragma once

#include <array>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "roomwise/network/graph/onnx_graph.h"

namespace roomwise::network {

// What the weights of a new network are, until others are loaded or learned. Each tensor draws from
// a stream of its own, keyed by its name, so that it does not change when others are added.
struct RandomWeights {
  std::uint64_t seed = 1;
  // Batch norms do nothing yet, as before training; otherwise they have gains, shifts and
  // statistics as a trained network might.
  bool neutral_norms = false;
};

struct ConvolutionShape {
  std::int64_t outputs = 0;
  std::array<std::int64_t, 2> kernel{1, 1};
  std::array<std::int64_t, 2> strides{1, 1};
  std::array<std::int64_t, 2> pads{0, 0};  // before and after, each
  std::int64_t groups = 1;
  bool has_bias = false;
};

struct PoolingShape {
  std::array<std::int64_t, 2> kernel{1, 1};
  std::array<std::int64_t, 2> strides{1, 1};
  std::array<std::int64_t, 2> pads{0, 0};
};

// Builds an ONNX graph (opset 14) node by node. A value is named after the node that gives it, and
// nodes after where they stand ("Mixed_5b.branch1x1.conv"); parameters are named as PyTorch names
// them: NODE.weight, NODE.bias, NODE.running_mean, NODE.running_var. Sizes of values are followed
// from the input on; the batch, the height and the width may be dynamic.
//
// Layers that do not fit their inputs, unknown values and names that are taken are bugs of the
// caller and throw std::invalid_argument naming the node.
class GraphBuilder {
 public:
  using Value = std::string;

  explicit GraphBuilder(RandomWeights weights = {}) : weights_(weights) { graph_.opset = 14; }

  Value input(const std::string& name, const Shape& shape);
  void output(const Value& value);

  // He's weights (2015, evenly spread): what comes out of a convolution or a linear layer behind a
  // ReLU is of the order of what came in.
  Value convolution(const Value& from, const std::string& name, const ConvolutionShape& shape);
  // From batch x inputs; weights are outputs x inputs, and there is a bias.
  Value linear(const Value& from, const std::string& name, std::int64_t outputs);
  Value batch_norm(const Value& from, const std::string& name, float epsilon = 1e-5F);

  Value relu(const Value& from, const std::string& name);

  Value max_pool(const Value& from, const std::string& name, const PoolingShape& shape);
  // The mean counts the padding's zeros, as PyTorch's does.
  Value average_pool(const Value& from, const std::string& name, const PoolingShape& shape);
  Value global_average_pool(const Value& from, const std::string& name);
  Value flatten(const Value& from, const std::string& name);  // to batch x values
  // Joined along the channels.
  Value concat(std::span<const Value> values, const std::string& name);
  Value add(const Value& a, const Value& b, const std::string& name);
  // Does nothing but in training, when it drops values at this rate.
  Value dropout(const Value& from, const std::string& name, float rate = 0.5F);

  // Any other operator, and what it knows beforehand.
  using Attributes = std::map<std::string, Attribute>;
  Value add_node(const char* operation, const std::string& name, std::vector<Value> inputs,
                 Shape output_shape, Attributes attributes = {});
  Value add_constant(const std::string& name, Shape shape, std::vector<float> values);

  [[nodiscard]] const Shape& shape(const Value& value) const;
  [[nodiscard]] OnnxGraph take() { return std::move(graph_); }

 private:
  Value pool(const char* operation, const Value& from, const std::string& name,
             const PoolingShape& shape, Attributes attributes);
  // Evenly spread numbers of this mean and standard deviation.
  std::string add_random(const std::string& name, const Shape& shape, double mean, double spread);

  RandomWeights weights_;
  OnnxGraph graph_;
  std::map<Value, Shape> shapes_;
};

// The names of the constants that a network learns: weights, biases and batch norm's statistics;
// not limits, rates and shapes.
[[nodiscard]] std::vector<std::string> parameters_of(const OnnxGraph& graph);

}  // namespace roomwise::network
