#include "roomwise/network/graph/onnx_graph.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace roomwise::network {
namespace {

template <typename T>
T value_or(const Attribute* found, T Attribute::*field, T otherwise) {
  return found == nullptr ? std::move(otherwise) : found->*field;
}

bool takes_weights(const Node& node) {
  return node.operation == "Conv" || node.operation == "ConvTranspose" ||
         node.operation == "Gemm" || node.operation == "MatMul" ||
         node.operation == "BatchNormalization";
}

Expected<void> check_numbers(const std::string& name, const Constant& constant, bool is_weight) {
  const auto is_finite = [](float number) { return std::isfinite(number); };
  if (std::ranges::all_of(constant.floats, is_finite)) return {};
  const auto is_of_mask = [](float number) { return number == 0 || std::isinf(number); };
  if (!is_weight && std::ranges::all_of(constant.floats, is_of_mask)) return {};
  return fail(
      "its tensor \"{}\" holds {} of {} numbers that are not finite (NaN or infinite), so it "
      "computes nothing of use; get the file again, or train or export the network anew",
      name, constant.size() - std::ranges::count_if(constant.floats, is_finite), constant.size());
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

Expected<void> check_weights(const OnnxGraph& graph) {
  std::set<std::string> weights;
  for (const Node& node : graph.nodes) {
    if (takes_weights(node)) weights.insert(node.inputs.begin(), node.inputs.end());
  }
  for (const auto& [name, constant] : graph.constants)
    ROOMWISE_RETURN_IF_ERROR(check_numbers(name, *constant, weights.contains(name)));
  for (const Node& node : graph.nodes) {
    for (const auto& [_, attribute] : node.attributes) {
      if (attribute.tensor == nullptr || node.outputs.empty()) continue;
      const std::string& name = node.outputs.front();
      ROOMWISE_RETURN_IF_ERROR(check_numbers(name, *attribute.tensor, weights.contains(name)));
    }
  }
  return {};
}

}  // namespace roomwise::network
