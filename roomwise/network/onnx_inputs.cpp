#include "roomwise/network/onnx_inputs.h"

#include <functional>
#include <set>

namespace roomwise::network {
namespace {

using Span = std::span<const std::uint8_t>;

// One field of a protobuf message: a number, or bytes (a text or an inner message).
struct Field {
  std::uint64_t number = 0;
  std::uint64_t value = 0;
  Span bytes;
};

Unexpected damaged() {
  return fail("is no ONNX network, or a truncated one");
}

Expected<std::uint64_t> take_varint(Span& rest) {
  std::uint64_t value = 0;
  for (int shift = 0; shift < 64 && !rest.empty(); shift += 7) {
    const std::uint8_t byte = rest.front();
    rest = rest.subspan(1);
    value |= std::uint64_t{byte & 0x7FU} << shift;
    if (byte < 0x80) return value;
  }
  return damaged();
}

Expected<Span> take_bytes(Span& rest, std::uint64_t size) {
  if (size > rest.size()) return damaged();
  const Span bytes = rest.first(static_cast<std::size_t>(size));
  rest = rest.subspan(bytes.size());
  return bytes;
}

// The fields of a message, in its order (the wire format of Protocol Buffers).
Expected<std::vector<Field>> fields_of(Span message) {
  enum WireType { kVarint = 0, kFixed64 = 1, kBytes = 2, kFixed32 = 5 };
  std::vector<Field> fields;
  while (!message.empty()) {
    ROOMWISE_TRY(const std::uint64_t tag, take_varint(message));
    Field field;
    field.number = tag >> 3;
    switch (tag & 7) {
      case kVarint: {
        ROOMWISE_TRY(field.value, take_varint(message));
        break;
      }
      case kBytes: {
        ROOMWISE_TRY(const std::uint64_t size, take_varint(message));
        ROOMWISE_TRY(field.bytes, take_bytes(message, size));
        break;
      }
      case kFixed64:
      case kFixed32: {
        ROOMWISE_TRY(field.bytes, take_bytes(message, (tag & 7) == kFixed64 ? 8 : 4));
        break;
      }
      default:
        return damaged();
    }
    fields.push_back(field);
  }
  return fields;
}

// Calls `visit` for every inner message that is reached by the field numbers of `path`.
Expected<void> visit_inner(Span message, std::span<const std::uint64_t> path,
                           const std::function<Expected<void>(Span)>& visit) {
  if (path.empty()) return visit(message);
  ROOMWISE_TRY(const std::vector<Field> fields, fields_of(message));
  for (const Field& field : fields) {
    if (field.number != path.front()) continue;
    ROOMWISE_CHECK_OK(visit_inner(field.bytes, path.subspan(1), visit));
  }
  return {};
}

std::string text_of(Span bytes) {
  return {bytes.begin(), bytes.end()};
}

// The field numbers of onnx.proto (ONNX IR version 3 and later).
constexpr std::uint64_t kGraph = 7;                   // ModelProto.graph
constexpr std::uint64_t kInitializerName[] = {5, 8};  // GraphProto.initializer.name
constexpr std::uint64_t kInput[] = {11};              // GraphProto.input
constexpr std::uint64_t kInputName = 1;               // ValueInfoProto.name
// ValueInfoProto.type.tensor_type.shape.dim
constexpr std::uint64_t kDimension[] = {2, 1, 2, 1};
constexpr std::uint64_t kDimensionSize = 1;  // Dimension.dim_value; another field names a free one

Expected<OnnxInput> read_input(Span value_info) {
  OnnxInput input;
  ROOMWISE_TRY(const std::vector<Field> fields, fields_of(value_info));
  for (const Field& field : fields) {
    if (field.number == kInputName) input.name = text_of(field.bytes);
  }
  ROOMWISE_CHECK_OK(visit_inner(value_info, kDimension, [&](Span dimension) -> Expected<void> {
    ROOMWISE_TRY(const std::vector<Field> sizes, fields_of(dimension));
    input.shape.push_back(OnnxInput::kFree);
    for (const Field& size : sizes) {
      if (size.number == kDimensionSize && size.value > 0) {
        input.shape.back() = static_cast<std::int64_t>(size.value);
      }
    }
    return {};
  }));
  return input;
}

}  // namespace

Expected<std::vector<OnnxInput>> read_onnx_inputs(std::span<const std::uint8_t> onnx) {
  ROOMWISE_TRY(const std::vector<Field> model, fields_of(onnx));
  std::vector<OnnxInput> inputs;
  for (const Field& field : model) {
    if (field.number != kGraph) continue;
    // Older files list every weight among the inputs.
    std::set<std::string> weights;
    ROOMWISE_CHECK_OK(visit_inner(field.bytes, kInitializerName, [&](Span name) -> Expected<void> {
      weights.insert(text_of(name));
      return {};
    }));
    ROOMWISE_CHECK_OK(visit_inner(field.bytes, kInput, [&](Span value) -> Expected<void> {
      ROOMWISE_TRY(OnnxInput input, read_input(value));
      if (!weights.contains(input.name)) inputs.push_back(std::move(input));
      return {};
    }));
  }
  if (inputs.empty()) return damaged();
  return inputs;
}

}  // namespace roomwise::network
