#pragma once

#include <cstdint>
#include <optional>

#include "roomwise/base/byte_reader.h"

namespace roomwise {

// The fields of a protobuf message as they come, whatever its schema. Source of the encoding:
// https://protobuf.dev/programming-guides/encoding
class ProtobufReader {
 public:
  explicit ProtobufReader(std::span<const std::uint8_t> message) : reader_(message) {}

  struct Field {
    std::uint64_t number = 0;
    std::uint64_t value = 0;  // of an integer, or the bits of a float or double
    // Of a text, bytes, a message within or numbers packed together (then holds_bytes), or of a
    // float or double: the message's own.
    std::span<const std::uint8_t> bytes;
    bool holds_bytes = false;

    [[nodiscard]] std::string_view text() const {
      return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    }
    [[nodiscard]] double as_double() const { return std::bit_cast<double>(value); }
    [[nodiscard]] std::int64_t as_integer() const { return static_cast<std::int64_t>(value); }
    [[nodiscard]] std::uint32_t as_count() const { return static_cast<std::uint32_t>(value); }
  };

  // Nothing at the end, and where the bytes make no sense: then ok() is false.
  std::optional<Field> next() {
    if (reader_.remaining() == 0) return std::nullopt;
    Field field;
    const std::uint64_t tag = varint();
    field.number = tag >> 3U;
    switch (tag & 7U) {
      case 0:
        field.value = varint();
        break;
      case 1:
        field.bytes = reader_.bytes(8);
        if (ok()) field.value = load<std::uint64_t>(field.bytes.data());
        break;
      case 2:
        field.bytes = reader_.bytes(varint());
        field.holds_bytes = true;
        break;
      case 5:
        field.bytes = reader_.bytes(4);
        if (ok()) field.value = load<std::uint32_t>(field.bytes.data());
        break;
      default:
        is_known_ = false;
    }
    return ok() ? std::optional(field) : std::nullopt;
  }
  [[nodiscard]] bool ok() const { return reader_.ok() && is_known_; }
  [[nodiscard]] bool at_end() const { return reader_.remaining() == 0; }

  // One of the numbers that are packed together: for a field's bytes alone. 0 where there is none.
  std::uint64_t varint() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 64; shift += 7) {
      const auto byte = reader_.number<std::uint8_t>();
      value |= std::uint64_t{byte & 127U} << shift;
      if ((byte & 128U) == 0) return value;
    }
    is_known_ = false;
    return 0;
  }

 private:
  ByteReader reader_;
  bool is_known_ = true;
};

}  // namespace roomwise
