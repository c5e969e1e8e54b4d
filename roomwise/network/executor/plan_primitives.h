#pragma once

#include <array>
#include <oneapi/dnnl/dnnl.hpp>
#include <optional>
#include <span>
#include <string>

#include "roomwise/network/graph/program.h"

namespace roomwise::network {

// How the program's words are said to oneDNN.

struct Elementwise {
  dnnl::algorithm function;
  float alpha;
  float beta;
};
[[nodiscard]] Elementwise elementwise_of(const Activation& activation);
void append_activations(dnnl::post_ops& after, std::span<const Activation> activations);

// The memory that a primitive works in is part of the plan's: primitives are shared by threads.
[[nodiscard]] dnnl::primitive_attr user_scratchpad();

[[nodiscard]] dnnl::memory::dims dims_of(const std::array<std::int64_t, 2>& pair);
[[nodiscard]] dnnl::memory::desc any_layout(
    const dnnl::memory::dims& dims, dnnl::memory::data_type type = dnnl::memory::data_type::f32);
[[nodiscard]] dnnl::memory::dims weight_dims(const Convolution& convolution);

// Which of oneDNN's ways to convolve.
struct ConvolutionWay {
  dnnl::algorithm algorithm = dnnl::algorithm::convolution_direct;
  dnnl::memory::data_type weights = dnnl::memory::data_type::f32;
  dnnl::primitive_attr attributes;
  std::string implementation = {};  // oneDNN's name of it; empty: what oneDNN takes
};
using ConvolutionDescription = dnnl::convolution_forward::primitive_desc;

// From and to these layouts; absent where oneDNN has no fast way for them.
[[nodiscard]] std::optional<ConvolutionDescription> fast_convolution(const Convolution& convolution,
                                                                     const ConvolutionWay& way,
                                                                     const dnnl::memory::desc& from,
                                                                     const dnnl::memory::desc& to,
                                                                     const dnnl::engine& engine);
// In these layouts if there is a fast way for them, else in those that oneDNN chooses.
[[nodiscard]] ConvolutionDescription choose_convolution(const Convolution& convolution,
                                                        bool may_use_winograd,
                                                        const dnnl::memory::desc& from,
                                                        const dnnl::memory::desc& to,
                                                        const dnnl::engine& engine);

}  // namespace roomwise::network
