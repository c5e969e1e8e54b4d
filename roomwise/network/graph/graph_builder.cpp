#include "roomwise/network/graph/graph_builder.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "roomwise/base/random.h"
#include "roomwise/network/graph/program.h"

namespace roomwise::network {
namespace {

void expect(bool is_right, const std::string& node, const char* what) {
  if (!is_right) throw std::invalid_argument(fmt::format("node \"{}\": {}", node, what));
}

// FNV-1a, the same on every machine.
std::uint64_t key_of(std::string_view name) {
  std::uint64_t key = 0xCBF29CE484222325;
  for (const char letter : name) key = (key ^ static_cast<unsigned char>(letter)) * 0x100000001B3;
  return key;
}

Attribute integers(std::initializer_list<std::int64_t> values) {
  return Attribute(std::vector<std::int64_t>(values));
}

// Kernel, strides and pads as ONNX says them.
template <typename Window>
std::map<std::string, Attribute> window_attributes(const Window& window) {
  const auto [height, width] = window.pads;
  return {{"kernel_shape", integers({window.kernel[0], window.kernel[1]})},
          {"strides", integers({window.strides[0], window.strides[1]})},
          {"pads", integers({height, width, height, width})}};
}

// Height and width after a window has moved over them.
template <typename Window>
Shape moved_over(const std::string& node, const Shape& from, std::int64_t channels,
                 const Window& window) {
  expect(from.size() == 4, node, "takes batch x channels x height x width");
  Shape to{from[0], channels, from[2], from[3]};
  for (std::size_t i = 0; i < 2; ++i) {
    if (from[2 + i] == GraphInput::kDynamic) continue;
    const std::int64_t room = from[2 + i] + 2 * window.pads[i] - window.kernel[i];
    expect(room >= 0, node, "its window is larger than its input");
    to[2 + i] = room / window.strides[i] + 1;
  }
  return to;
}

}  // namespace

GraphBuilder::Value GraphBuilder::input(const std::string& name, const Shape& shape) {
  expect(shapes_.insert({name, shape}).second, name, "the name is taken");
  graph_.inputs.push_back({name, shape});
  return name;
}

void GraphBuilder::output(const Value& value) {
  graph_.output_shapes[value] = shape(value);
  graph_.outputs.push_back(value);
}

const Shape& GraphBuilder::shape(const Value& value) const {
  const auto found = shapes_.find(value);
  expect(found != shapes_.end(), value, "nothing gives this value");
  return found->second;
}

GraphBuilder::Value GraphBuilder::add_node(const char* operation, const std::string& name,
                                           std::vector<Value> inputs, Shape output_shape,
                                           Attributes attributes) {
  expect(shapes_.insert({name, std::move(output_shape)}).second, name, "the name is taken");
  graph_.nodes.push_back({name, operation, "", std::move(inputs), {name}, std::move(attributes)});
  return name;
}

GraphBuilder::Value GraphBuilder::add_constant(const std::string& name, Shape shape,
                                               std::vector<float> values) {
  Constant constant;
  constant.shape = std::move(shape);
  constant.floats = std::move(values);
  const bool is_new =
      graph_.constants.insert({name, std::make_shared<const Constant>(std::move(constant))}).second;
  expect(is_new && !shapes_.contains(name), name, "the name is taken");
  return name;
}

std::string GraphBuilder::add_random(const std::string& name, const Shape& shape, double mean,
                                     double spread) {
  RandomStream random(weights_.seed, {key_of(name)});
  std::vector<float> values(element_count(shape));
  const double reach = std::sqrt(3.0) * spread;
  for (float& value : values) value = static_cast<float>(mean + reach * (2 * random.uniform() - 1));
  return add_constant(name, shape, std::move(values));
}

GraphBuilder::Value GraphBuilder::convolution(const Value& from, const std::string& name,
                                              const ConvolutionShape& shape) {
  const Shape& input = this->shape(from);
  Shape output = moved_over(name, input, shape.outputs, shape);
  expect(shape.groups > 0 && input[1] % shape.groups == 0 && shape.outputs % shape.groups == 0 &&
             shape.outputs > 0,
         name, "its channels are no multiple of its groups");
  const Shape weights{shape.outputs, input[1] / shape.groups, shape.kernel[0], shape.kernel[1]};
  const auto summed =
      static_cast<double>(element_count(weights)) / static_cast<double>(shape.outputs);
  std::vector<Value> inputs{from, add_random(name + ".weight", weights, 0, std::sqrt(2 / summed))};
  if (shape.has_bias) inputs.push_back(add_random(name + ".bias", {shape.outputs}, 0, 0.1));
  Attributes attributes = window_attributes(shape);
  attributes["group"] = Attribute(shape.groups);
  return add_node("Conv", name, std::move(inputs), std::move(output), std::move(attributes));
}

GraphBuilder::Value GraphBuilder::linear(const Value& from, const std::string& name,
                                         std::int64_t outputs) {
  const Shape& input = shape(from);
  expect(input.size() == 2 && outputs > 0, name, "takes batch x values");
  const double spread = std::sqrt(2 / static_cast<double>(input[1]));
  std::vector<Value> inputs{from, add_random(name + ".weight", {outputs, input[1]}, 0, spread),
                            add_random(name + ".bias", {outputs}, 0, 0.1)};
  return add_node("Gemm", name, std::move(inputs), {input[0], outputs},
                  {{"transB", Attribute(std::int64_t{1})}});
}

GraphBuilder::Value GraphBuilder::batch_norm(const Value& from, const std::string& name,
                                             float epsilon) {
  const Shape& input = shape(from);
  expect(input.size() >= 2, name, "takes batch x channels");
  const Shape channels{input[1]};
  const double spread = weights_.neutral_norms ? 0 : 0.1;
  std::vector<Value> inputs{from, add_random(name + ".weight", channels, 1, spread),
                            add_random(name + ".bias", channels, 0, spread),
                            add_random(name + ".running_mean", channels, 0, spread),
                            add_random(name + ".running_var", channels, 1, spread)};
  return add_node("BatchNormalization", name, std::move(inputs), input,
                  {{"epsilon", Attribute(epsilon)}});
}

GraphBuilder::Value GraphBuilder::relu(const Value& from, const std::string& name) {
  return add_node("Relu", name, {from}, shape(from));
}

GraphBuilder::Value GraphBuilder::pool(const char* operation, const Value& from,
                                       const std::string& name, const PoolingShape& shape,
                                       Attributes attributes) {
  const Shape& input = this->shape(from);
  Shape output = moved_over(name, input, input.size() == 4 ? input[1] : 0, shape);
  attributes.merge(window_attributes(shape));
  return add_node(operation, name, {from}, std::move(output), std::move(attributes));
}
GraphBuilder::Value GraphBuilder::max_pool(const Value& from, const std::string& name,
                                           const PoolingShape& shape) {
  return pool("MaxPool", from, name, shape, {});
}
GraphBuilder::Value GraphBuilder::average_pool(const Value& from, const std::string& name,
                                               const PoolingShape& shape) {
  return pool("AveragePool", from, name, shape,
              {{"count_include_pad", Attribute(std::int64_t{1})}});
}
GraphBuilder::Value GraphBuilder::global_average_pool(const Value& from, const std::string& name) {
  const Shape& input = shape(from);
  expect(input.size() == 4, name, "takes batch x channels x height x width");
  return add_node("GlobalAveragePool", name, {from}, {input[0], input[1], 1, 1});
}

GraphBuilder::Value GraphBuilder::flatten(const Value& from, const std::string& name) {
  const Shape& input = shape(from);
  std::int64_t values = 1;
  for (std::size_t i = 1; i < input.size(); ++i) {
    expect(input[i] != GraphInput::kDynamic, name, "the height and the width are free");
    values *= input[i];
  }
  return add_node("Flatten", name, {from}, {input[0], values},
                  {{"axis", Attribute(std::int64_t{1})}});
}

GraphBuilder::Value GraphBuilder::concat(std::span<const Value> values, const std::string& name) {
  expect(!values.empty(), name, "joins nothing");
  Shape joined = shape(values.front());
  expect(joined.size() >= 2, name, "takes batch x channels");
  joined[1] = 0;
  for (const Value& value : values) {
    Shape part = shape(value);
    expect(part.size() == joined.size(), name, "its inputs do not fit each other");
    joined[1] += std::exchange(part[1], joined[1]);
    part[1] = joined[1];
    expect(part == joined, name, "its inputs do not fit each other");
  }
  return add_node("Concat", name, {values.begin(), values.end()}, std::move(joined),
                  {{"axis", Attribute(std::int64_t{1})}});
}

GraphBuilder::Value GraphBuilder::add(const Value& a, const Value& b, const std::string& name) {
  expect(shape(a) == shape(b), name, "its inputs do not fit each other");
  return add_node("Add", name, {a, b}, shape(a));
}

GraphBuilder::Value GraphBuilder::dropout(const Value& from, const std::string& name, float rate) {
  expect(rate >= 0 && rate < 1, name, "its rate must be from 0 to below 1");
  return add_node("Dropout", name, {from, add_constant(name + ".ratio", {}, {rate})}, shape(from));
}

std::vector<std::string> parameters_of(const OnnxGraph& graph) {
  static const std::set<std::string> learned{"Conv", "Gemm", "MatMul", "BatchNormalization"};
  std::set<std::string> names;
  for (const Node& node : graph.nodes) {
    if (!learned.contains(node.operation)) continue;
    for (const std::string& input : node.inputs) {
      if (graph.constants.contains(input)) names.insert(input);
    }
  }
  return {names.begin(), names.end()};
}

}  // namespace roomwise::network
