#include "roomwise/network/graph/onnx_graph.h"

namespace roomwise::network {

std::string shape_text(const Shape& shape) {
  std::string text;
  for (const std::int64_t size : shape) {
    text += text.empty() ? "" : "x";
    text += size == GraphInput::kDynamic ? "?" : fmt::format("{}", size);
  }
  return text.empty() ? "of a single number" : text;
}

const Attribute* Node::find(const std::string& attribute) const {
  const auto found = attributes.find(attribute);
  return found == attributes.end() ? nullptr : &found->second;
}

std::int64_t Node::integer(const std::string& attribute, std::int64_t otherwise) const {
  const Attribute* found = find(attribute);
  return found == nullptr ? otherwise : found->integer;
}

float Node::number(const std::string& attribute, float otherwise) const {
  const Attribute* found = find(attribute);
  return found == nullptr ? otherwise : found->number;
}

std::string Node::text(const std::string& attribute, const char* otherwise) const {
  const Attribute* found = find(attribute);
  return found == nullptr ? otherwise : found->text;
}

std::vector<std::int64_t> Node::integers(const std::string& attribute,
                                         std::vector<std::int64_t> otherwise) const {
  const Attribute* found = find(attribute);
  return found == nullptr ? std::move(otherwise) : found->integers;
}

}  // namespace roomwise::network
