#include "roomwise/network/formats/onnx_writer.h"

#include <algorithm>

#include "roomwise/network/formats/number_formats.h"
#include "roomwise/network/formats/protobuf_writer.h"
#include "roomwise/network/graph/program.h"

namespace roomwise::network {
namespace {

using AttributeKind = Attribute::Kind;

template <typename Number>
std::span<const std::uint8_t> bytes_of(const std::vector<Number>& numbers) {
  return {reinterpret_cast<const std::uint8_t*>(numbers.data()), numbers.size() * sizeof(Number)};
}

ProtobufWriter tensor_message(const std::string& name, const Constant& constant) {
  ProtobufWriter tensor;
  for (const std::int64_t size : constant.shape) tensor.add(1, size);
  tensor.add(2, static_cast<std::int64_t>(constant.is_integer ? NumberFormat::kInteger64
                                                              : NumberFormat::kFloat));
  tensor.add(8, name);
  tensor.add(9, constant.is_integer ? bytes_of(constant.integers) : bytes_of(constant.floats));
  return tensor;
}

ProtobufWriter attribute_message(const std::string& name, const Attribute& attribute) {
  ProtobufWriter message;
  message.add(1, name);
  switch (attribute.kind) {
    case AttributeKind::kNone:
      break;
    case AttributeKind::kNumber:
      message.add(2, attribute.number);
      break;
    case AttributeKind::kInteger:
      message.add(3, attribute.integer);
      break;
    case AttributeKind::kText:
      message.add(4, attribute.text);
      break;
    case AttributeKind::kTensor:
      message.add(5, tensor_message("", *attribute.tensor).bytes());
      break;
    case AttributeKind::kNumbers:
      for (const float number : attribute.numbers) message.add(7, number);
      break;
    case AttributeKind::kIntegers:
      for (const std::int64_t integer : attribute.integers) message.add(8, integer);
      break;
  }
  message.add(20, static_cast<std::int64_t>(attribute.kind));
  return message;
}

ProtobufWriter node_message(const Node& node) {
  ProtobufWriter message;
  for (const std::string& input : node.inputs) message.add(1, input);
  for (const std::string& output : node.outputs) message.add(2, output);
  message.add(3, node.name);
  message.add(4, node.operation);
  for (const auto& [name, attribute] : node.attributes) {
    if (attribute.kind != AttributeKind::kNone)
      message.add(5, attribute_message(name, attribute).bytes());
  }
  if (!node.domain.empty()) message.add(7, node.domain);
  return message;
}

// ValueInfoProto; no shape: not stated.
ProtobufWriter value_message(const std::string& name, const Shape& shape, bool is_integer) {
  ProtobufWriter dimensions, tensor, type, message;
  for (const std::int64_t size : shape) {
    ProtobufWriter dimension;
    if (size != GraphInput::kDynamic) dimension.add(1, size);
    dimensions.add(1, dimension.bytes());
  }
  tensor.add(
      1, static_cast<std::int64_t>(is_integer ? NumberFormat::kInteger64 : NumberFormat::kFloat));
  if (!shape.empty()) tensor.add(2, dimensions.bytes());
  type.add(1, tensor.bytes());
  message.add(1, name);
  message.add(2, type.bytes());
  return message;
}

// The first version of the file format that knows the opset.
std::int64_t format_version(std::int64_t opset) {
  return opset >= 15 ? 8 : opset >= 12 ? 7 : opset - 5;
}

Expected<void> check(const OnnxGraph& graph) {
  if (graph.opset < 10 || graph.opset > 17)
    return fail("the network is of opset {}; 10 to 17 are understood", graph.opset);
  if (graph.inputs.empty() || graph.outputs.empty())
    return fail("the network has {} inputs and {} outputs; an ONNX file needs one of each",
                graph.inputs.size(), graph.outputs.size());
  for (const auto& [name, constant] : graph.constants) {
    if (constant->size() != element_count(constant->shape)) {
      return fail("the tensor \"{}\" has {} values, not those of its shape {}", name,
                  constant->size(), shape_text(constant->shape));
    }
  }
  for (const Node& node : graph.nodes) {
    for (const auto& [name, attribute] : node.attributes) {
      if (attribute.kind == AttributeKind::kTensor && attribute.tensor == nullptr)
        return fail("the attribute \"{}\" of node \"{}\" lacks its tensor", name, node.name);
    }
  }
  return {};
}

}  // namespace

Expected<Bytes> write_onnx_graph(const OnnxGraph& graph) {
  ROOMWISE_RETURN_IF_ERROR(check(graph));
  ProtobufWriter message;
  for (const Node& node : graph.nodes) message.add(1, node_message(node).bytes());
  message.add(2, std::string_view("network"));
  for (const auto& [name, constant] : graph.constants)
    message.add(5, tensor_message(name, *constant).bytes());
  for (const GraphInput& input : graph.inputs)
    message.add(11, value_message(input.name, input.shape, input.is_integer).bytes());
  for (const std::string& output : graph.outputs) {
    const auto stated = graph.output_shapes.find(output);
    const Shape shape = stated == graph.output_shapes.end() ? Shape{} : stated->second;
    const bool is_index = std::ranges::any_of(graph.nodes, [&](const Node& node) {
      return node.operation == "ArgMax" && node.outputs == std::vector{output};
    });
    message.add(12, value_message(output, shape, is_index).bytes());
  }

  ProtobufWriter opset, model;
  opset.add(1, std::string_view());
  opset.add(2, graph.opset);
  model.add(1, format_version(graph.opset));
  model.add(2, std::string_view("roomwise"));
  model.add(7, message.bytes());
  model.add(8, opset.bytes());
  return model.take();
}

}  // namespace roomwise::network
