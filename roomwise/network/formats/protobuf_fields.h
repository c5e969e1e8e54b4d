#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "roomwise/base/expected.h"

namespace roomwise::network {

// One field of a protobuf message: a number, or bytes (a text, an inner message, packed numbers).
// The bytes are the file's own: they live as long as it does.
struct ProtobufField {
  std::uint64_t number = 0;
  std::uint64_t value = 0;
  bool holds_bytes = false;
  std::span<const std::uint8_t> bytes;

  [[nodiscard]] std::int64_t integer() const { return static_cast<std::int64_t>(value); }
  [[nodiscard]] std::string text() const { return {bytes.begin(), bytes.end()}; }
};

// The fields of a message in its order, by the wire format of Protocol Buffers. Fails where the
// bytes end too early or are no message; never reads or allocates beyond what they say and hold.
[[nodiscard]] Expected<std::vector<ProtobufField>> protobuf_fields(
    std::span<const std::uint8_t> message);

// A repeated number: packed into bytes, or one of several fields.
[[nodiscard]] Expected<std::vector<std::int64_t>> protobuf_integers(const ProtobufField& field);

}  // namespace roomwise::network
