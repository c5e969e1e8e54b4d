#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "roomwise/base/file.h"

// Plain numbers as bytes and back, to the bit and in this machine's order: for the program itself,
// which wrote them.
namespace roomwise {

class PlainWriter {
 public:
  // What is to come takes about so many bytes: no more are taken while it is written.
  void reserve(std::size_t bytes) { bytes_.reserve(bytes_.size() + bytes); }
  template <typename T>
  void put(const T* values, std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    const std::size_t end = bytes_.size();
    bytes_.resize(end + count * sizeof(T));
    if (count > 0) std::memcpy(bytes_.data() + end, values, count * sizeof(T));
  }
  template <typename T>
  void put(const T& value) {
    put(&value, 1);
  }
  // With its length in front.
  void put_text(std::string_view text) {
    put(static_cast<std::uint32_t>(text.size()));
    put(text.data(), text.size());
  }
  [[nodiscard]] Bytes take() { return std::move(bytes_); }

 private:
  Bytes bytes_;
};

// Reads zeros from where the bytes end, and remembers that.
class PlainReader {
 public:
  explicit PlainReader(std::span<const std::uint8_t> bytes) : rest_(bytes) {}
  template <typename T>
  void get(T* values, std::size_t count) {
    const std::size_t size = count * sizeof(T);
    if (size > rest_.size()) {
      is_short_ = true;
      rest_ = {};
    }
    if (size == 0 || is_short_) return;
    std::memcpy(values, rest_.data(), size);
    rest_ = rest_.subspan(size);
  }
  template <typename T>
  [[nodiscard]] T get() {
    T value{};
    get(&value, 1);
    return value;
  }
  [[nodiscard]] std::string get_text(std::size_t size) {
    is_short_ = is_short_ || size > rest_.size();
    std::string text(is_short_ ? 0 : size, '\0');
    get(text.data(), text.size());
    return text;
  }
  // What put_text() wrote.
  [[nodiscard]] std::string get_text() { return get_text(get<std::uint32_t>()); }
  // A number of things of which each takes so many bytes; 0 where there cannot be as many.
  [[nodiscard]] std::size_t get_count(std::size_t bytes_each) {
    const auto count = get<std::uint64_t>();
    if (count <= rest_.size() / bytes_each) return count;
    is_short_ = true;
    return 0;
  }
  // How long the rows are that follow; 0 where there cannot be as many so long.
  [[nodiscard]] std::size_t get_columns(std::size_t rows, std::size_t bytes_each) {
    constexpr std::uint64_t kMax = 65536;
    const auto columns = get<std::uint64_t>();
    if (columns <= kMax && columns * rows * bytes_each <= rest_.size()) return columns;
    is_short_ = true;
    return 0;
  }
  [[nodiscard]] bool is_short() const { return is_short_; }
  [[nodiscard]] std::size_t left() const { return rest_.size(); }
  [[nodiscard]] bool is_whole() const { return !is_short_ && rest_.empty(); }

 private:
  std::span<const std::uint8_t> rest_;
  bool is_short_ = false;
};

}  // namespace roomwise
