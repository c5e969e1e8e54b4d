#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

#include "roomwise/base/file.h"

namespace roomwise::rooms {

static_assert(std::endian::native == std::endian::little, "stored numbers are little-endian");

// Writes texts and numbers, as they are.
class NumberWriter {
 public:
  template <typename Number>
  void numbers(std::span<const Number> values) {
    const std::size_t before = bytes_.size();
    bytes_.resize(before + values.size_bytes());
    if (!values.empty()) std::memcpy(bytes_.data() + before, values.data(), values.size_bytes());
  }
  template <typename Number>
  void number(Number value) {
    numbers(std::span<const Number>(&value, 1));
  }
  void raw(std::string_view text) { numbers(std::span<const char>(text)); }
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

  template <typename Number>
  void numbers(std::span<Number> values) {
    if (values.size_bytes() > rest_.size()) {
      failed_ = true;
      std::ranges::fill(values, Number{});
    } else if (!values.empty()) {
      std::memcpy(values.data(), rest_.data(), values.size_bytes());
      rest_ = rest_.subspan(values.size_bytes());
    }
  }
  template <typename Number>
  Number number() {
    Number value{};
    numbers(std::span(&value, 1));
    return value;
  }
  std::string raw(std::size_t size) {
    if (size > rest_.size()) failed_ = true;
    std::string text(failed_ ? 0 : size, '\0');
    numbers(std::span(text));
    return text;
  }
  std::string text() { return raw(number<std::uint32_t>()); }

  [[nodiscard]] bool failed() const { return failed_; }
  [[nodiscard]] std::size_t left() const { return rest_.size(); }

 private:
  std::span<const std::uint8_t> rest_;
  bool failed_ = false;
};

}  // namespace roomwise::rooms
