#include "roomwise/recording/data_lines.h"

namespace roomwise::recording {
namespace {

std::vector<std::string_view> words_of(std::string_view line) {
  constexpr std::string_view kBlanks = " \t\r\v\f";
  std::vector<std::string_view> words;
  for (std::size_t begin = line.find_first_not_of(kBlanks); begin != std::string_view::npos;) {
    if (line[begin] == '#') break;
    const std::size_t end = line.find_first_of(kBlanks, begin);
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kBlanks, end);
  }
  return words;
}

}  // namespace

std::vector<DataLine> data_lines(std::string_view text) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  std::vector<DataLine> lines;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    const bool complete = end != std::string_view::npos;
    auto words = words_of(text.substr(0, end));
    if (!words.empty()) lines.push_back({number, std::move(words), complete});
    text.remove_prefix(complete ? end + 1 : text.size());
  }
  return lines;
}

}  // namespace roomwise::recording
