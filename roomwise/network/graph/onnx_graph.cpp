#include "roomwise/network/graph/onnx_graph.h"

namespace roomwise::network {
namespace {

template <typename T>
T value_or(const Attribute* found, T Attribute::*field, T otherwise) {
  return found == nullptr ? std::move(otherwise) : found->*field;
}

}  // namespace

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
  return value_or(find(attribute), &Attribute::integer, otherwise);
}
float Node::number(const std::string& attribute, float otherwise) const {
  return value_or(find(attribute), &Attribute::number, otherwise);
}
std::string Node::text(const std::string& attribute, const char* otherwise) const {
  return value_or<std::string>(find(attribute), &Attribute::text, otherwise);
}
std::vector<std::int64_t> Node::integers(const std::string& attribute,
                                         std::vector<std::int64_t> otherwise) const {
  return value_or(find(attribute), &Attribute::integers, std::move(otherwise));
}

}  // namespace roomwise::network
