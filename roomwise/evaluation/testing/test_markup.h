#pragma once

#include <cstddef>
#include <string>

// For tests of what is written as HTML or SVG.
namespace roomwise::evaluation {

inline std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t i = text.find(part); i != std::string::npos; i = text.find(part, i + 1)) ++count;
  return count;
}

}  // namespace roomwise::evaluation
