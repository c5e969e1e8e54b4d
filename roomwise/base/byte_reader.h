#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <type_traits>

namespace roomwise {

// The number that begins at `bytes`, which must hold it.
template <typename Number>
[[nodiscard]] Number load(const std::uint8_t* bytes, std::endian order = std::endian::little) {
  static_assert(std::is_arithmetic_v<Number>);
  std::array<std::uint8_t, sizeof(Number)> raw{};
  std::memcpy(raw.data(), bytes, raw.size());
  if (order != std::endian::native) std::ranges::reverse(raw);
  return std::bit_cast<Number>(raw);
}

// Reads numbers and texts from bytes that may lie about their lengths, little-endian. What lies
// beyond the end reads as zero or empty, and from then on ok() is false: callers ask once, after
// all fields.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] std::size_t position() const { return position_; }
  [[nodiscard]] std::size_t remaining() const { return bytes_.size() - position_; }

  template <typename Number>
  Number number(std::endian order = std::endian::little) {
    const auto field = bytes(sizeof(Number));
    return ok_ ? load<Number>(field.data(), order) : Number{};
  }
  std::span<const std::uint8_t> bytes(std::uint64_t size) {
    if (!ok_ || size > remaining()) {
      ok_ = false;
      return {};
    }
    const auto part = bytes_.subspan(position_, static_cast<std::size_t>(size));
    position_ += part.size();
    return part;
  }
  std::string_view text(std::uint64_t size) {
    const auto part = bytes(size);
    return {reinterpret_cast<const char*>(part.data()), part.size()};
  }
  // With the length in front, as `Length`.
  template <typename Length>
  std::span<const std::uint8_t> counted_bytes() {
    return bytes(number<Length>());
  }
  template <typename Length>
  std::string_view counted_text() {
    return text(number<Length>());
  }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t position_ = 0;
  bool ok_ = true;
};

}  // namespace roomwise
