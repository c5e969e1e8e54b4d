#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "roomwise/network/graph/onnx_graph.h"

namespace roomwise::network {

// The least and the largest number of a value: each halfway between the mean of some inputs and the
// most of any, so that what few of them reach is cut off and the others are rounded less.
struct ActivationRange {
  float least = 0;
  float most = 0;

  friend bool operator==(const ActivationRange&, const ActivationRange&) = default;
};

// How a network is worked out in 8 bits: what its layers gave on some inputs.
struct EightBitRanges {
  Shape input;  // of each of those, and of all that it will be asked about
  // What has fewer channels stays in floats, which costs some of the time that is gained
  // (docs/experiments/network-8-bits.md).
  std::int64_t min_channels = 1;
  std::map<std::string, ActivationRange> of_layers = {};  // by names_of_layers() (quantization.h)
};

}  // namespace roomwise::network
