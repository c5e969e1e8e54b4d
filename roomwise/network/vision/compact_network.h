#pragma once

#include "roomwise/network/formats/model_card.h"
#include "roomwise/network/graph/graph_builder.h"

namespace roomwise::network {

struct CompactOptions {
  std::int64_t classes = 32;
  std::int64_t batch = 1;  // GraphInput::kDynamic: any
  RandomWeights weights{.seed = 1, .neutral_norms = true};
};

// A small network of our own for whole pictures: plain 3x3 convolutions, each with batch norm, that
// halve the picture five times, with sums past pairs of them where it is small already (K. He et
// al., "Deep residual learning for image recognition", 2016). Takes "picture" (batch x 3 x 128 x
// 128) and gives "logits", the scores of the classes before softmax; the value "features", batch x
// 256, tells rooms apart. Its weights are random until it is trained.
[[nodiscard]] OnnxGraph compact_network(const CompactOptions& options = {});

// How pictures are put into it and what comes out; without labels.
[[nodiscard]] ModelCard compact_card();

}  // namespace roomwise::network
