#include "roomwise/network/formats/protobuf_writer.h"

#include <bit>

namespace roomwise::network {
namespace {

enum WireType { kVarint = 0, kBytes = 2, kFixed32 = 5 };

}  // namespace

void ProtobufWriter::add(std::uint64_t number, std::int64_t value) {
  add_tag(number, kVarint);
  add_varint(static_cast<std::uint64_t>(value));
}

void ProtobufWriter::add(std::uint64_t number, float value) {
  add_tag(number, kFixed32);
  const auto bits = std::bit_cast<std::uint32_t>(value);
  for (int shift = 0; shift < 32; shift += 8)
    bytes_.push_back(static_cast<std::uint8_t>((bits >> shift) & 0xFF));
}

void ProtobufWriter::add(std::uint64_t number, std::string_view text) {
  add(number, std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

void ProtobufWriter::add(std::uint64_t number, std::span<const std::uint8_t> bytes) {
  add_tag(number, kBytes);
  add_varint(bytes.size());
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
}

void ProtobufWriter::add_tag(std::uint64_t number, std::uint64_t wire_type) {
  add_varint(number << 3 | wire_type);
}

void ProtobufWriter::add_varint(std::uint64_t value) {
  for (; value >= 0x80; value >>= 7)
    bytes_.push_back(static_cast<std::uint8_t>((value & 0x7F) | 0x80));
  bytes_.push_back(static_cast<std::uint8_t>(value));
}

}  // namespace roomwise::network
