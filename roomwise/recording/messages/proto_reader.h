#pragma once

#include <cstdint>
#include <optional>

#include "roomwise/recording/bytes/byte_reader.h"

namespace roomwise::recording {

// The fields of a protobuf message as they come, whatever its schema. Source of the encoding:
// https://protobuf.dev/programming-guides/encoding
class ProtoReader {
 public:
  explicit ProtoReader(std::span<const std::uint8_t> message) : reader_(message) {}

  struct Field {
    std::uint32_t number = 0;
    std::uint64_t value = 0;              // of an integer, or the bits of a float or double
    std::span<const std::uint8_t> bytes;  // of a text, bytes or a message within

    [[nodiscard]] std::string_view text() const {
      return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    }
    [[nodiscard]] double as_double() const { return std::bit_cast<double>(value); }
  };

  // Nothing at the end, and where the bytes make no sense: then ok() is false.
  std::optional<Field> next() {
    if (reader_.remaining() == 0) return std::nullopt;
    Field field;
    const std::uint64_t tag = varint();
    field.number = static_cast<std::uint32_t>(tag >> 3U);
    switch (tag & 7U) {
      case 0:
        field.value = varint();
        break;
      case 1:
        field.value = reader_.number<std::uint64_t>();
        break;
      case 2:
        field.bytes = reader_.bytes(varint());
        break;
      case 5:
        field.value = reader_.number<std::uint32_t>();
        break;
      default:
        is_known_ = false;
    }
    return ok() ? std::optional(field) : std::nullopt;
  }
  [[nodiscard]] bool ok() const { return reader_.ok() && is_known_; }

 private:
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

  ByteReader reader_;
  bool is_known_ = true;
};

}  // namespace roomwise::recording
