#pragma once

#include <cstdint>
#include <string>

#include "roomwise/network/onnx_graph.h"

namespace roomwise::network::training {

// The network with a new last layer, a Gemm of `classes` outputs on its features, and that as its
// only output. What the features do not need is left out. Feature maps are averaged over the
// picture first. Weights are drawn by `seed`, small enough that all classes begin nearly alike.
//
// features: the name of a value or node. Fails where it is not there.
struct NewHead {
  OnnxGraph graph;
  std::string logits;  // its output: a score a class, before softmax
};
[[nodiscard]] Expected<NewHead> with_new_head(OnnxGraph graph, const std::string& features,
                                              std::size_t classes, std::uint64_t seed);

// What a Softmax gives is what it is given, else the value itself: training works on scores before
// it.
[[nodiscard]] std::string before_softmax(const OnnxGraph& graph, const std::string& value);

}  // namespace roomwise::network::training
