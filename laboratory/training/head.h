#pragma once

#include <cstdint>
#include <string>

#include "roomwise/network/graph/onnx_graph.h"

namespace roomwise::training {

// A network with new last layers.
struct NewHead {
  network::OnnxGraph graph;
  std::string logits;      // its first output: a score a class, before softmax
  std::string aux_logits;  // its second one, of a head that helps to train; empty: none
};
// The network with a new last layer, a Gemm of `classes` outputs on its features. Feature maps are
// averaged over the picture first. A second head (an output that a Gemm gives and whose name begins
// with "aux") stays and gets such a layer too. What neither needs is left out. Weights are drawn by
// `seed`, small enough that all classes begin nearly alike.
//
// features: the name of a value or node. Fails where it is not there.
[[nodiscard]] Expected<NewHead> with_new_head(network::OnnxGraph graph, const std::string& features,
                                              std::size_t classes, std::uint64_t seed);

// The network with this output alone and what that needs.
[[nodiscard]] network::OnnxGraph reduced_to(network::OnnxGraph graph, const std::string& output);

// What a Softmax gives is what it is given, else the value itself: training works on scores before
// it.
[[nodiscard]] std::string before_softmax(const network::OnnxGraph& graph, const std::string& value);

}  // namespace roomwise::training
