#include "roomwise/network/formats/protobuf_fields.h"

namespace roomwise::network {
namespace {

using Span = std::span<const std::uint8_t>;

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

}  // namespace

Expected<std::vector<ProtobufField>> protobuf_fields(Span message) {
  enum WireType { kVarint = 0, kFixed64 = 1, kBytes = 2, kFixed32 = 5 };
  std::vector<ProtobufField> fields;
  while (!message.empty()) {
    ROOMWISE_TRY(const std::uint64_t tag, take_varint(message));
    ProtobufField field;
    field.number = tag >> 3;
    switch (tag & 7) {
      case kVarint: {
        ROOMWISE_TRY(field.value, take_varint(message));
        break;
      }
      case kBytes: {
        ROOMWISE_TRY(const std::uint64_t size, take_varint(message));
        ROOMWISE_TRY(field.bytes, take_bytes(message, size));
        field.holds_bytes = true;
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

Expected<std::vector<std::int64_t>> protobuf_integers(const ProtobufField& field) {
  if (!field.holds_bytes) return std::vector<std::int64_t>{field.integer()};
  std::vector<std::int64_t> integers;
  for (Span rest = field.bytes; !rest.empty();) {
    ROOMWISE_TRY(const std::uint64_t value, take_varint(rest));
    integers.push_back(static_cast<std::int64_t>(value));
  }
  return integers;
}

}  // namespace roomwise::network
