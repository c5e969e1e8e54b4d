#pragma once

#include <charconv>
#include <string_view>

#include "roomwise/base/expected.h"

namespace roomwise::bench {

// What a program takes for a count: a whole number from 1 on.
inline Expected<int> parse_count(std::string_view text, std::string_view usage) {
  int count = 0;
  const char* const end = text.data() + text.size();
  const auto [parsed, error] = std::from_chars(text.data(), end, count);
  if (error != std::errc() || parsed != end || count < 1) {
    return fail("'{}' is no whole number from 1 on; usage: {}", text, usage);
  }
  return count;
}

// Of a program that takes a count and nothing else; `usual` where it is left out.
inline Expected<int> only_count(int argc, char** argv, int usual, std::string_view usage) {
  if (argc > 2) return fail("'{}' is one argument too many; usage: {}", argv[2], usage);
  return argc > 1 ? parse_count(argv[1], usage) : Expected<int>(usual);
}

}  // namespace roomwise::bench
