#pragma once

#include <cstdint>
#include <string>
#include <vector>

// Small ONNX files, made by hand, for tests.
namespace roomwise::testing {

// Just enough of protobuf's wire format to write small ONNX files by hand.
inline std::string varint(std::uint64_t value) {
  std::string bytes;
  for (; value >= 0x80; value >>= 7) bytes.push_back(static_cast<char>((value & 0x7f) | 0x80));
  bytes.push_back(static_cast<char>(value));
  return bytes;
}
inline std::string field(int number, std::uint64_t value) {
  return varint(static_cast<std::uint64_t>(number) << 3) + varint(value);
}
inline std::string field(int number, const std::string& bytes) {
  return varint(static_cast<std::uint64_t>(number) << 3 | 2) + varint(bytes.size()) + bytes;
}

// ValueInfoProto of a float tensor.
inline std::string tensor_info(const std::string& name, const std::vector<std::uint64_t>& shape) {
  std::string dimensions;
  for (const std::uint64_t size : shape) dimensions += field(1, field(1, size));
  return field(1, name) + field(2, field(1, field(1, 1) + field(2, dimensions)));
}
// NodeProto without attributes.
inline std::string node(const std::string& operation, const std::string& input,
                        const std::string& output) {
  return field(1, input) + field(2, output) + field(3, output + "_node") + field(4, operation);
}
// AttributeProto: a whole number, a number, a text, whole numbers.
inline std::string attribute(const std::string& name, std::int64_t value) {
  return field(5, field(1, name) + field(3, static_cast<std::uint64_t>(value)) + field(20, 2));
}
inline std::string attribute(const std::string& name, int value) {
  return attribute(name, std::int64_t{value});
}
inline std::string attribute(const std::string& name, float value) {
  const std::string bytes(reinterpret_cast<const char*>(&value), sizeof value);
  return field(5, field(1, name) + varint(2 << 3 | 5) + bytes + field(20, 1));
}
inline std::string attribute(const std::string& name, const char* value) {
  return field(5, field(1, name) + field(4, std::string(value)) + field(20, 3));
}
inline std::string attribute(const std::string& name, const std::vector<std::int64_t>& values) {
  std::string message = field(1, name);
  for (const std::int64_t value : values) message += field(8, static_cast<std::uint64_t>(value));
  return field(5, message + field(20, 7));
}
// NodeProto with attributes, named after its first output.
inline std::string layer(const std::string& operation, const std::vector<std::string>& inputs,
                         const std::vector<std::string>& outputs,
                         const std::vector<std::string>& attributes = {}) {
  std::string message;
  for (const std::string& input : inputs) message += field(1, input);
  for (const std::string& output : outputs) message += field(2, output);
  message += field(3, outputs.front() + "_node") + field(4, operation);
  for (const std::string& text : attributes) message += text;
  return message;
}
// TensorProto of floats or whole numbers.
inline std::string tensor(const std::string& name, const std::vector<std::int64_t>& shape,
                          const std::vector<float>& values) {
  std::string message;
  for (const std::int64_t size : shape) message += field(1, static_cast<std::uint64_t>(size));
  const std::string bytes(reinterpret_cast<const char*>(values.data()),
                          values.size() * sizeof(float));
  return message + field(2, 1) + field(8, name) + field(9, bytes);
}
inline std::string tensor(const std::string& name, const std::vector<std::int64_t>& shape,
                          const std::vector<std::int64_t>& values) {
  std::string message;
  for (const std::int64_t size : shape) message += field(1, static_cast<std::uint64_t>(size));
  for (const std::int64_t value : values) message += field(7, static_cast<std::uint64_t>(value));
  return message + field(2, 7) + field(8, name);
}

struct TinyOutput {
  std::string name;
  std::vector<std::uint64_t> shape;
};
// ModelProto: nodes in a row from "picture" to the outputs.
inline std::string onnx(const std::vector<std::string>& nodes,
                        const std::vector<std::uint64_t>& input,
                        const std::vector<TinyOutput>& outputs) {
  std::string graph;
  for (const std::string& text : nodes) graph += field(1, text);
  graph += field(2, std::string("tiny")) + field(11, tensor_info("picture", input));
  for (const TinyOutput& output : outputs)
    graph += field(12, tensor_info(output.name, output.shape));
  return field(1, 7) + field(7, graph) + field(8, field(1, std::string()) + field(2, 11));
}

// The same with weights (TensorProto) and another opset.
struct TinyGraph {
  std::vector<std::string> nodes;
  std::vector<std::string> constants;
  std::vector<std::uint64_t> input;
  std::vector<TinyOutput> outputs;
  std::uint64_t opset = 11;
};
inline std::string onnx(const TinyGraph& tiny) {
  std::string graph;
  for (const std::string& text : tiny.nodes) graph += field(1, text);
  graph += field(2, std::string("tiny"));
  for (const std::string& constant : tiny.constants) graph += field(5, constant);
  graph += field(11, tensor_info("picture", tiny.input));
  for (const TinyOutput& output : tiny.outputs)
    graph += field(12, tensor_info(output.name, output.shape));
  return field(1, 7) + field(7, graph) + field(8, field(1, std::string()) + field(2, tiny.opset));
}

// A network of three scores: the mean of each colour plane as it is put in.
inline std::string mean_color_network() {
  return onnx({node("GlobalAveragePool", "picture", "pooled"), node("Flatten", "pooled", "means")},
              {1, 3, 4, 6}, {{"means", {1, 3}}});
}

}  // namespace roomwise::testing
