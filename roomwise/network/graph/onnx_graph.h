#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/base/expected.h"

namespace roomwise::network {

using Shape = std::vector<std::int64_t>;

// "1x3x224x224"; a dynamic size is "?".
[[nodiscard]] std::string shape_text(const Shape& shape);

// The numbers that a graph holds, row by row: floats, or integers (of 32 or 64 bits, or truth
// values). The other of the two lists is empty.
struct Constant {
  Shape shape;
  bool is_integer = false;
  std::vector<float> floats;
  std::vector<std::int64_t> integers;

  [[nodiscard]] std::size_t size() const { return is_integer ? integers.size() : floats.size(); }
};
using ConstantPointer = std::shared_ptr<const Constant>;

// The field that its kind names is set. A kind without use here is read as none.
struct Attribute {
  // AttributeProto.AttributeType
  enum class Kind {
    kNone = 0,
    kNumber = 1,
    kInteger = 2,
    kText = 3,
    kTensor = 4,
    kNumbers = 6,
    kIntegers = 7
  };

  Attribute() = default;
  explicit Attribute(std::int64_t value) : kind(Kind::kInteger), integer(value) {}
  explicit Attribute(float value) : kind(Kind::kNumber), number(value) {}
  explicit Attribute(std::string value) : kind(Kind::kText), text(std::move(value)) {}
  explicit Attribute(std::vector<std::int64_t> values)
      : kind(Kind::kIntegers), integers(std::move(values)) {}

  Kind kind = Kind::kNone;
  std::int64_t integer = 0;
  float number = 0;
  std::string text;
  std::vector<std::int64_t> integers;
  std::vector<float> numbers;
  ConstantPointer tensor;
};

struct Node {
  std::string name;
  std::string operation;            // "Conv"
  std::string domain;               // empty: ONNX's own operators
  std::vector<std::string> inputs;  // names of values; an empty name is an input left out
  std::vector<std::string> outputs;
  std::map<std::string, Attribute> attributes;

  [[nodiscard]] const Attribute* find(const std::string& attribute) const;
  [[nodiscard]] std::int64_t integer(const std::string& attribute, std::int64_t otherwise) const;
  [[nodiscard]] float number(const std::string& attribute, float otherwise) const;
  [[nodiscard]] std::string text(const std::string& attribute, const char* otherwise) const;
  [[nodiscard]] std::vector<std::int64_t> integers(const std::string& attribute,
                                                   std::vector<std::int64_t> otherwise) const;
};

// What a network asks for.
struct GraphInput {
  static constexpr std::int64_t kDynamic = -1;  // a size that the file leaves open

  std::string name;
  Shape shape;
  bool is_integer = false;  // whole numbers
};

// An ONNX network as its file says it, before anything is made of it.
struct OnnxGraph {
  std::int64_t opset = 0;  // the version of ONNX's own operators
  std::vector<Node> nodes;
  std::map<std::string, ConstantPointer> constants;  // initializers, by name
  std::vector<GraphInput> inputs;                    // without those that the file fills itself
  std::vector<std::string> outputs;
  std::map<std::string, Shape> output_shapes;  // by name, where they are stated
};

// Reads an ONNX file (IR version 3 and later). Fails where the bytes are no ONNX file, end too
// early, or hold a tensor that is not as large as its shape says, lies in another file, or is of
// a type without use here. Takes memory of a few times the bytes' size at most.
[[nodiscard]] Expected<OnnxGraph> read_onnx_graph(std::span<const std::uint8_t> onnx);

// Fails where weights hold NaN or infinities, and names the tensor. Masks and limits, which are of
// infinities and zeros alone, may hold infinities.
[[nodiscard]] Expected<void> check_weights(const OnnxGraph& graph);

}  // namespace roomwise::network
