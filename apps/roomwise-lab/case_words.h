#pragma once

#include <set>
#include <string>
#include <vector>

namespace roomwise::app {

// The words of a --case of fit-instances and fit-localizer, between commas; those that begin with
// source= apart.
struct CaseWords {
  std::vector<std::string> positional;
  std::set<std::string> sources;
};
[[nodiscard]] inline CaseWords split_case(const std::string& text) {
  constexpr std::string_view kSource = "source=";
  CaseWords words;
  for (std::size_t begin = 0, end = 0; end != std::string::npos; begin = end + 1) {
    end = text.find(',', begin);
    std::string word = text.substr(begin, end == std::string::npos ? end : end - begin);
    if (word.starts_with(kSource)) {
      words.sources.insert(word.substr(kSource.size()));
    } else {
      words.positional.push_back(std::move(word));
    }
  }
  return words;
}

}  // namespace roomwise::app
