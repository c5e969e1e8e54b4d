#include "roomwise/network/graph/onnx_graph.h"

#include <algorithm>
#include <cstring>
#include <functional>

#include "roomwise/base/protobuf_reader.h"
#include "roomwise/network/formats/number_formats.h"

namespace roomwise::network {
namespace {

using Span = std::span<const std::uint8_t>;
using Field = ProtobufReader::Field;

Unexpected damaged() {
  return fail("is no ONNX network, or a truncated one");
}

// The fields of a message in its order; never takes memory beyond what it holds.
Expected<std::vector<Field>> fields_of(Span message) {
  ProtobufReader reader(message);
  std::vector<Field> fields;
  while (const auto field = reader.next()) fields.push_back(*field);
  if (!reader.ok()) return damaged();
  return fields;
}

// A repeated number: packed into bytes, or one of several fields.
Expected<std::vector<std::int64_t>> repeated_integers(const Field& field) {
  if (!field.holds_bytes) return std::vector{field.as_integer()};
  std::vector<std::int64_t> integers;
  ProtobufReader packed(field.bytes);
  while (packed.ok() && !packed.at_end())
    integers.push_back(static_cast<std::int64_t>(packed.varint()));
  if (!packed.ok()) return damaged();
  return integers;
}

template <typename Number>
std::vector<Number> numbers_of(Span bytes) {
  std::vector<Number> numbers(bytes.size() / sizeof(Number));
  if (!numbers.empty()) std::memcpy(numbers.data(), bytes.data(), numbers.size() * sizeof(Number));
  return numbers;
}

struct TensorFields {
  std::string name;
  NumberFormat format{0};
  Span raw;
  bool external = false;
};

Expected<TensorFields> read_tensor_fields(Span message, Constant& constant) {
  TensorFields tensor;
  ROOMWISE_TRY(const auto fields, fields_of(message));
  for (const Field& field : fields) {
    switch (field.number) {
      case 1:
      case 5:
      case 7: {  // dims, int32_data, int64_data
        ROOMWISE_TRY(const auto integers, repeated_integers(field));
        auto& list = field.number == 1 ? constant.shape : constant.integers;
        list.insert(list.end(), integers.begin(), integers.end());
        break;
      }
      case 2:
        tensor.format = static_cast<NumberFormat>(field.value);
        break;
      case 4: {  // float_data
        const auto numbers = numbers_of<float>(field.bytes);
        constant.floats.insert(constant.floats.end(), numbers.begin(), numbers.end());
        break;
      }
      case 8:
        tensor.name = field.text();
        break;
      case 9:
        tensor.raw = field.bytes;
        break;
      case 13:
      case 14:
        tensor.external = tensor.external || field.number == 13 || field.value == 1;
        break;
      default:
        break;
    }
  }
  return tensor;
}

Expected<std::pair<std::string, ConstantPointer>> read_tensor(Span message) {
  auto constant = std::make_shared<Constant>();
  ROOMWISE_TRY(const TensorFields tensor, read_tensor_fields(message, *constant));
  if (tensor.external) return fail("keeps the tensor \"{}\" in another file", tensor.name);
  constant->is_integer = is_integer(tensor.format);
  if (!tensor.raw.empty()) {
    if (std::ranges::count(number_formats(), tensor.format, &NumberFormatNames::format) == 0) {
      return fail("has a tensor \"{}\" of the type {}; floats and integers are understood",
                  tensor.name, static_cast<std::int64_t>(tensor.format));
    }
    Shape shape = std::move(constant->shape);
    *constant = numbers_from(tensor.format, tensor.raw);
    constant->shape = std::move(shape);
  }
  const auto count = values_of(constant->shape);
  if (!count) {
    return fail("has a tensor \"{}\" of the impossible shape {}", tensor.name,
                shape_text(constant->shape));
  }
  if (*count != constant->size()) {
    return fail("has a tensor \"{}\" of {} values, not of the {} of its shape {}", tensor.name,
                constant->size(), *count, shape_text(constant->shape));
  }
  return std::pair(tensor.name, ConstantPointer(std::move(constant)));
}

Expected<std::pair<std::string, Attribute>> read_attribute(Span message) {
  using Kind = Attribute::Kind;
  std::string name;
  Attribute attribute;
  ROOMWISE_TRY(const auto fields, fields_of(message));
  for (const Field& field : fields) {
    switch (field.number) {
      case 1:
        name = field.text();
        break;
      case 2:
      case 7: {
        const auto numbers = numbers_of<float>(field.bytes);
        attribute.kind = field.number == 2 ? Kind::kNumber : Kind::kNumbers;
        if (field.number == 2 && !numbers.empty()) attribute.number = numbers.front();
        if (field.number == 7)
          attribute.numbers.insert(attribute.numbers.end(), numbers.begin(), numbers.end());
        break;
      }
      case 3:
        attribute.kind = Kind::kInteger;
        attribute.integer = field.as_integer();
        break;
      case 4:
        attribute.kind = Kind::kText;
        attribute.text = field.text();
        break;
      case 5: {
        ROOMWISE_TRY(auto tensor, read_tensor(field.bytes));
        attribute.kind = Kind::kTensor;
        attribute.tensor = std::move(tensor.second);
        break;
      }
      case 8: {
        ROOMWISE_TRY(const auto integers, repeated_integers(field));
        attribute.kind = Kind::kIntegers;
        attribute.integers.insert(attribute.integers.end(), integers.begin(), integers.end());
        break;
      }
      case 20:  // the type, without which an empty list would be nothing
        if (attribute.kind != Kind::kNone) break;
        for (const Kind kind :
             {Kind::kNumber, Kind::kInteger, Kind::kText, Kind::kNumbers, Kind::kIntegers}) {
          if (field.value == static_cast<std::uint64_t>(kind)) attribute.kind = kind;
        }
        break;
      default:
        break;
    }
  }
  return std::pair(std::move(name), std::move(attribute));
}

Expected<Node> read_node(Span message) {
  Node node;
  ROOMWISE_TRY(const auto fields, fields_of(message));
  for (const Field& field : fields) {
    if (field.number == 1) node.inputs.emplace_back(field.text());
    if (field.number == 2) node.outputs.emplace_back(field.text());
    if (field.number == 3) node.name = field.text();
    if (field.number == 4) node.operation = field.text();
    if (field.number == 7) node.domain = field.text();
    if (field.number != 5) continue;
    ROOMWISE_TRY(auto attribute, read_attribute(field.bytes));
    node.attributes.insert(std::move(attribute));
  }
  return node;
}

// Calls `visit` for every inner message that is reached by the field numbers of `path`.
Expected<void> visit_inner(Span message, std::span<const std::uint64_t> path,
                           const std::function<Expected<void>(Span)>& visit) {
  if (path.empty()) return visit(message);
  ROOMWISE_TRY(const auto fields, fields_of(message));
  for (const Field& field : fields) {
    if (field.number != path.front()) continue;
    ROOMWISE_RETURN_IF_ERROR(visit_inner(field.bytes, path.subspan(1), visit));
  }
  return {};
}

Expected<GraphInput> read_value_info(Span message) {
  // ValueInfoProto.type.tensor_type.shape.dim
  constexpr std::uint64_t kTensor[] = {2, 1};
  constexpr std::uint64_t kDimension[] = {2, 1, 2, 1};
  GraphInput input;
  ROOMWISE_TRY(const auto fields, fields_of(message));
  for (const Field& field : fields) {
    if (field.number == 1) input.name = field.text();
  }
  ROOMWISE_RETURN_IF_ERROR(visit_inner(message, kTensor, [&](Span tensor) -> Expected<void> {
    ROOMWISE_TRY(const auto of_tensor, fields_of(tensor));
    for (const Field& field : of_tensor) {
      if (field.number == 1) input.is_integer = is_integer(static_cast<NumberFormat>(field.value));
    }
    return {};
  }));
  ROOMWISE_RETURN_IF_ERROR(visit_inner(message, kDimension, [&](Span dimension) -> Expected<void> {
    ROOMWISE_TRY(const auto sizes, fields_of(dimension));
    input.shape.push_back(GraphInput::kDynamic);
    for (const Field& size : sizes) {
      // 1: dim_value; another field names a free one.
      if (size.number == 1 && size.as_integer() > 0) input.shape.back() = size.as_integer();
    }
    return {};
  }));
  return input;
}

Expected<void> read_graph(Span message, OnnxGraph& graph) {
  ROOMWISE_TRY(const auto fields, fields_of(message));
  std::vector<GraphInput> inputs;
  for (const Field& field : fields) {
    switch (field.number) {
      case 1: {
        ROOMWISE_TRY(Node node, read_node(field.bytes));
        graph.nodes.push_back(std::move(node));
        break;
      }
      case 5: {
        ROOMWISE_TRY(auto tensor, read_tensor(field.bytes));
        graph.constants.insert(std::move(tensor));
        break;
      }
      case 11:
      case 12: {
        ROOMWISE_TRY(GraphInput value, read_value_info(field.bytes));
        if (field.number == 11) {
          inputs.push_back(std::move(value));
          break;
        }
        graph.outputs.push_back(value.name);
        if (!value.shape.empty()) graph.output_shapes.insert({value.name, std::move(value.shape)});
        break;
      }
      default:
        break;
    }
  }
  // Older files list every weight among the inputs.
  for (GraphInput& input : inputs) {
    if (!graph.constants.contains(input.name)) graph.inputs.push_back(std::move(input));
  }
  return {};
}

}  // namespace

Expected<OnnxGraph> read_onnx_graph(Span onnx) {
  OnnxGraph graph;
  ROOMWISE_TRY(const auto model, fields_of(onnx));
  for (const Field& field : model) {
    if (field.number == 7) ROOMWISE_RETURN_IF_ERROR(read_graph(field.bytes, graph));
    if (field.number != 8) continue;
    // opset_import: 1 names the domain, 2 the version.
    ROOMWISE_TRY(const auto fields, fields_of(field.bytes));
    std::string domain;
    std::int64_t version = 0;
    for (const Field& part : fields) {
      if (part.number == 1) domain = part.text();
      if (part.number == 2) version = part.as_integer();
    }
    if (domain.empty() || domain == "ai.onnx") graph.opset = version;
  }
  if (graph.inputs.empty() || graph.outputs.empty() || graph.opset <= 0) {
    return damaged();
  }
  return graph;
}

}  // namespace roomwise::network
