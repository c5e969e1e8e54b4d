#pragma once

#include <charconv>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

namespace roomwise::recording {

// A line of a text file that holds data, as words.
struct DataLine {
  std::size_t number = 0;  // in the file, from 1
  std::vector<std::string_view> words;
  bool complete = true;  // false for a last line without its line end
};

// The lines of `text` that hold data. Words are divided by blanks, a word that begins with '#'
// begins a comment; empty lines, carriage returns and a byte order mark are passed over. The words
// point into `text`.
[[nodiscard]] std::vector<DataLine> data_lines(std::string_view text);

// The whole word as a number; nothing where it is none or not finite.
template <typename Number>
[[nodiscard]] std::optional<Number> parse_number(std::string_view word) {
  Number number{};
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, number);
  if (error != std::errc() || stop != end) return std::nullopt;
  if constexpr (std::is_floating_point_v<Number>) {
    if (!std::isfinite(number)) return std::nullopt;
  }
  return number;
}

}  // namespace roomwise::recording
