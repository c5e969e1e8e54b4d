#pragma once

#include "roomwise/network/graph/graph_builder.h"

namespace roomwise::network {

struct InceptionOptions {
  std::int64_t classes = 1000;
  // The auxiliary classifier of the middle of the network, which helps it learn (needs 299 pixels).
  bool has_auxiliary_head = false;
  std::int64_t batch = 1;      // GraphInput::kDynamic: any
  std::int64_t side_px = 299;  // at least 75
  RandomWeights weights;
};

// Inception-v3 (C. Szegedy et al., "Rethinking the Inception Architecture for Computer Vision",
// 2015) as torchvision builds it: its parameters are those of torchvision's state dict, by name
// and shape. Takes "picture" (batch x 3 x side x side, values from -1 to 1) and gives "fc", the
// scores of the classes before softmax, and, second, "AuxLogits.fc" where there is that head. The
// features that a new last layer is learned on, batch x 2048, are the value "features".
[[nodiscard]] OnnxGraph inception_v3(const InceptionOptions& options = {});

}  // namespace roomwise::network
