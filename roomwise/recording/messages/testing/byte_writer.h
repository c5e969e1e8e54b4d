#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "roomwise/base/file.h"

namespace roomwise::recording::testing {

// Puts numbers and texts one behind the other, little-endian.
class ByteWriter {
 public:
  template <typename Number>
  ByteWriter& number(std::type_identity_t<Number> value) {
    return bytes({reinterpret_cast<const std::uint8_t*>(&value), sizeof(Number)});
  }
  ByteWriter& bytes(std::span<const std::uint8_t> bytes) {
    for (const std::uint8_t byte : bytes) bytes_.push_back(byte);
    return *this;
  }
  ByteWriter& text(std::string_view text) {
    return bytes({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  }
  template <typename Length>
  ByteWriter& counted(std::string_view text) {
    number<Length>(static_cast<Length>(text.size()));
    return this->text(text);
  }
  template <typename Length>
  ByteWriter& counted(std::span<const std::uint8_t> bytes) {
    number<Length>(static_cast<Length>(bytes.size()));
    return this->bytes(bytes);
  }
  [[nodiscard]] std::size_t size() const { return bytes_.size(); }
  [[nodiscard]] const Bytes& all() const { return bytes_; }
  [[nodiscard]] Bytes& all() { return bytes_; }

 private:
  Bytes bytes_;
};

}  // namespace roomwise::recording::testing
