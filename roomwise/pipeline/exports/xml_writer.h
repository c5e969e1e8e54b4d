#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace roomwise::pipeline {

// An XML document, element by element, indented. Names of elements and attributes are written as
// they are; texts and values are made safe: bytes that are no UTF-8 and what XML cannot hold become
// U+FFFD, control characters spaces.
class XmlWriter {
 public:
  using Attributes = std::vector<std::pair<std::string_view, std::string>>;

  void open(std::string_view name, const Attributes& attributes = {});
  // Of the element that was opened last and is not closed.
  void close();
  void leaf(std::string_view name, std::string_view text, const Attributes& attributes = {});
  void empty(std::string_view name, const Attributes& attributes);
  // Once, when all is closed.
  [[nodiscard]] std::string document() && { return std::move(text_); }

 private:
  void start(std::string_view name, const Attributes& attributes);

  std::string text_ = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  std::vector<std::string> open_;
};

}  // namespace roomwise::pipeline
