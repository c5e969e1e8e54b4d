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

// A network of three scores: the mean of each colour plane as it is put in.
inline std::string mean_color_network() {
  return onnx({node("GlobalAveragePool", "picture", "pooled"), node("Flatten", "pooled", "means")},
              {1, 3, 4, 6}, {{"means", {1, 3}}});
}

}  // namespace roomwise::testing
