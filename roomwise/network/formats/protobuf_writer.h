#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace roomwise::network {

// A protobuf message as it is written down, field by field (the counterpart of ProtobufReader).
class ProtobufWriter {
 public:
  void add(std::uint64_t number, std::int64_t value);
  void add(std::uint64_t number, float value);
  void add(std::uint64_t number, std::string_view text);
  // Bytes, or an inner message's.
  void add(std::uint64_t number, std::span<const std::uint8_t> bytes);
  [[nodiscard]] const std::vector<std::uint8_t>& bytes() const { return bytes_; }
  [[nodiscard]] std::vector<std::uint8_t> take() { return std::move(bytes_); }

 private:
  void add_tag(std::uint64_t number, std::uint64_t wire_type);
  void add_varint(std::uint64_t value);

  std::vector<std::uint8_t> bytes_;
};

}  // namespace roomwise::network
