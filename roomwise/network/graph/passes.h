#pragma once

#include "roomwise/network/graph/program.h"

namespace roomwise::network {

// What is done to a program before it is planned. Each leaves what comes out as it was, but for
// rounding; each can be left out, which the tests do.
struct PassOptions {
  bool folds_constants = true;    // floating-point arithmetic on weights (lowering.h)
  bool folds_padding = true;      // zeros put around a picture become the convolution's own pads
  bool folds_scales = true;       // batch normalisation becomes part of weights and biases
  bool fuses_activations = true;  // into convolutions; and x * sigmoid(x) into one function
  bool fuses_residuals = true;    // sums become part of a convolution
  bool combines_gathers = true;   // chains of joins, splits and channel shuffles become one
  bool swaps_means = true;        // a 1x1 convolution comes before a mean, on fewer channels
  bool concat_in_place = true;    // what is joined is written where it is wanted (plan.h)
  bool uses_winograd = true;      // for 3x3 convolutions (plan.h)
};

[[nodiscard]] Program run_passes(Program program, const PassOptions& options);

// The passes one by one.
void fold_padding(Program& program);
void fold_scales(Program& program);
void fuse_activations(Program& program);
void fuse_residuals(Program& program);
void combine_gathers(Program& program);
void move_means_behind_pointwise(Program& program);
// Takes out the layers whose results nobody uses.
void remove_unused(Program& program);

// Whether it gives input 0, 1, ... one after the other, each whole: a concatenation.
[[nodiscard]] bool concatenates_whole_inputs(const Program& program, const Layer& layer);

}  // namespace roomwise::network
