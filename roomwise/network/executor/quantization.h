#pragma once

#include <span>

#include "roomwise/network/graph/eight_bit_ranges.h"
#include "roomwise/network/graph/program.h"

namespace roomwise::network {

// Numbers in a shape, row by row.
struct Tensor;

// What every value of the program is on these inputs of its only input, each of its shape. Fails
// where there is none, or the program cannot be run.
[[nodiscard]] Expected<std::vector<ActivationRange>> calibrate_ranges(
    const Program& program, std::span<const Tensor> inputs);

// Of each layer its node, with a number where that name is taken by one before it. The same for the
// same file, passes and outputs.
[[nodiscard]] std::vector<std::string> names_of_layers(const Program& program);

// The ranges of what the layers give, and (by the name "") of the input, for keeping them; and
// back, by value, which fails where a layer has none.
[[nodiscard]] std::map<std::string, ActivationRange> named_ranges(
    const Program& program, std::span<const ActivationRange> ranges);
[[nodiscard]] Expected<std::vector<ActivationRange>> ranges_of_values(const Program& program,
                                                                      const EightBitRanges& ranges);

// Whether the layer can hand 8-bit numbers on as they are, from values of one step: maxima, small
// means, channels of whole values joined.
[[nodiscard]] bool preserves_quantization(const Program& program, const Layer& layer);

// Says which values are held in 8 bits (Value::eight_bits) by what was measured: what convolutions
// look at, of `min_channels` or more, and what is pooled or joined into that, with one step for
// all that share memory so. The plan then works these convolutions out in whole numbers: inputs in
// 8 bits, weights in 8 bits with a step an output channel, sums in 32 bits, as post-training
// quantisation does (R. Krishnamoorthi, "Quantizing deep convolutional networks for efficient
// inference", 2018). The picture itself, and all other layers, stay 32-bit floats.
void quantize(Program& program, std::span<const ActivationRange> ranges,
              std::int64_t min_channels = 1);

}  // namespace roomwise::network
