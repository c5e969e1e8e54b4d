#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "roomwise/base/file.h"

namespace roomwise::rooms {

// Writes texts and numbers, little-endian.
class NumberWriter {
 public:
  void raw(std::string_view text) {
    for (const char letter : text) bytes_.push_back(static_cast<std::uint8_t>(letter));
  }
  void number(std::uint32_t value) {
    for (int shift = 0; shift < 32; shift += 8) {
      bytes_.push_back(static_cast<std::uint8_t>(value >> shift));
    }
  }
  void real(float value) { number(std::bit_cast<std::uint32_t>(value)); }
  void real(double value) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    number(static_cast<std::uint32_t>(bits));
    number(static_cast<std::uint32_t>(bits >> 32U));
  }
  void text(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size()));
    raw(text);
  }
  Bytes take() { return std::move(bytes_); }

 private:
  Bytes bytes_;
};

// Reads what NumberWriter wrote. Reading past the end gives zeros and marks the reader as failed,
// so that a caller may check once.
class NumberReader {
 public:
  explicit NumberReader(std::span<const std::uint8_t> bytes) : rest_(bytes) {}

  std::string raw(std::size_t size) {
    if (size > rest_.size()) {
      failed_ = true;
      size = 0;
    }
    const std::string text(rest_.begin(), rest_.begin() + static_cast<std::ptrdiff_t>(size));
    rest_ = rest_.subspan(size);
    return text;
  }
  std::uint32_t number() {
    if (rest_.size() < 4) {
      failed_ = true;
      return 0;
    }
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value |= std::uint32_t{rest_[i]} << (8 * i);
    rest_ = rest_.subspan(4);
    return value;
  }
  float real() { return std::bit_cast<float>(number()); }
  double real_of_64_bits() {
    const std::uint64_t low = number();
    return std::bit_cast<double>(low | std::uint64_t{number()} << 32U);
  }
  std::string text() { return raw(number()); }

  [[nodiscard]] bool failed() const { return failed_; }
  [[nodiscard]] std::size_t left() const { return rest_.size(); }

 private:
  std::span<const std::uint8_t> rest_;
  bool failed_ = false;
};

}  // namespace roomwise::rooms
