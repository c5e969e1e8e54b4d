#pragma once

#include "roomwise/network/graph/graph_builder.h"
#include "roomwise/network/graph/program.h"

namespace roomwise::network::testing {

// Operators that no network of ours has, for graphs with all that is read.

using BuiltValue = GraphBuilder::Value;

inline BuiltValue hard_swish(GraphBuilder& builder, const BuiltValue& from,
                             const std::string& name) {
  return builder.add_node("HardSwish", name, {from}, builder.shape(from));
}
// clip(x / 6 + 1/2, 0, 1)
inline BuiltValue hard_sigmoid(GraphBuilder& builder, const BuiltValue& from,
                               const std::string& name) {
  return builder.add_node("HardSigmoid", name, {from}, builder.shape(from),
                          {{"alpha", Attribute(1.0F / 6)}, {"beta", Attribute(0.5F)}});
}
inline BuiltValue sigmoid(GraphBuilder& builder, const BuiltValue& from, const std::string& name) {
  return builder.add_node("Sigmoid", name, {from}, builder.shape(from));
}
// Along the last axis.
inline BuiltValue softmax(GraphBuilder& builder, const BuiltValue& from, const std::string& name) {
  return builder.add_node("Softmax", name, {from}, builder.shape(from),
                          {{"axis", Attribute(std::int64_t{-1})}});
}
inline BuiltValue relu6(GraphBuilder& builder, const BuiltValue& from, const std::string& name) {
  const BuiltValue low = builder.add_constant(name + ".min", {}, {0});
  const BuiltValue high = builder.add_constant(name + ".max", {}, {6});
  return builder.add_node("Clip", name, {from, low, high}, builder.shape(from));
}
// Sizes of 1 are repeated.
inline BuiltValue multiply(GraphBuilder& builder, const BuiltValue& a, const BuiltValue& b,
                           const std::string& name) {
  return builder.add_node("Mul", name, {a, b},
                          broadcast(builder.shape(a), builder.shape(b)).value());
}

}  // namespace roomwise::network::testing
