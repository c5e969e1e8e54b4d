#include "roomwise/network/executor/plan_primitives.h"

#include <algorithm>
#include <string>

#include "roomwise/network/executor/plan.h"

namespace roomwise::network {

using dnnl::algorithm;
using dnnl::memory;

Elementwise elementwise_of(const Activation& activation) {
  const auto [function, alpha, beta] = activation;
  switch (function) {
    case Activation::Function::kRelu:
      return {algorithm::eltwise_relu, alpha, 0};
    case Activation::Function::kClip:
      return {algorithm::eltwise_clip, alpha, beta};
    case Activation::Function::kSigmoid:
      return {algorithm::eltwise_logistic, 0, 0};
    case Activation::Function::kTanh:
      return {algorithm::eltwise_tanh, 0, 0};
    case Activation::Function::kExp:
      return {algorithm::eltwise_exp, 0, 0};
    case Activation::Function::kSquareRoot:
      return {algorithm::eltwise_sqrt, 0, 0};
    case Activation::Function::kPower:
      return {algorithm::eltwise_pow, 1, alpha};
    case Activation::Function::kErf:
      break;  // has a kernel of its own
    case Activation::Function::kLinear:
      return {algorithm::eltwise_linear, alpha, beta};
    case Activation::Function::kSwish:
      return {algorithm::eltwise_swish, 1, 0};
    case Activation::Function::kHardSwish:
      return {algorithm::eltwise_hardswish, 0, 0};
  }
  return {algorithm::eltwise_relu, 0, 0};
}

void append_activations(dnnl::post_ops& after, std::span<const Activation> activations) {
  for (const Activation& activation : activations) {
    const auto [function, alpha, beta] = elementwise_of(activation);
    after.append_eltwise(1, function, alpha, beta);
  }
}

dnnl::primitive_attr user_scratchpad() {
  dnnl::primitive_attr attributes;
  attributes.set_scratchpad_mode(dnnl::scratchpad_mode::user);
  return attributes;
}

memory::dims dims_of(const std::array<std::int64_t, 2>& pair) {
  return {pair[0], pair[1]};
}

memory::desc any_layout(const memory::dims& dims, memory::data_type type) {
  return {dims, type, memory::format_tag::any};
}

memory::dims weight_dims(const Convolution& convolution) {
  const Shape& shape = convolution.weights->shape;
  if (convolution.groups == 1) return {shape.begin(), shape.end()};
  return {convolution.groups, shape[0] / convolution.groups, shape[1], shape[2], shape[3]};
}

namespace {

ConvolutionDescription convolution_in(const Convolution& convolution, const ConvolutionWay& way,
                                      const memory::desc& from, const memory::desc& to,
                                      const dnnl::engine& engine) {
  const Window& window = convolution.window;
  // oneDNN counts the places between a window's places.
  const memory::dims dilations{window.dilations[0] - 1, window.dilations[1] - 1};
  const auto outputs = convolution.weights->shape[0];
  const memory::desc bias = convolution.bias.empty() ? memory::desc() : any_layout({outputs});
  const dnnl::convolution_forward::desc description(
      dnnl::prop_kind::forward_inference, way.algorithm, from,
      any_layout(weight_dims(convolution), way.weights), bias, to, dims_of(window.strides),
      dilations, dims_of(window.pads_begin), dims_of(window.pads_end));
  ConvolutionDescription found(description, way.attributes, engine);
  // Asked for while `description` lives.
  while (!way.implementation.empty() && found.impl_info_str() != way.implementation) {
    if (!found.next_impl()) throw dnnl::error(dnnl_unimplemented, "no such implementation");
  }
  return found;
}

// Whether Winograd's way (tiles of 2x2 places, 2.25 times fewer multiplications) is the faster one:
// as measured (docs/experiments/network-executor.md), which says it by the shape alone. For other
// than single pictures, whole blocks of channels and pads of at most 1 the bits would hang on the
// number of threads.
bool suits_winograd(const Convolution& convolution, const memory::desc& to) {
  constexpr std::int64_t kMinChannels = 32, kMinOutputs = 48, kMinSide = 12, kBlock = 16;
  using Pair = std::array<std::int64_t, 2>;
  const Window& window = convolution.window;
  const Shape& weights = convolution.weights->shape;
  const std::int64_t max_pad =
      std::max(std::ranges::max(window.pads_begin), std::ranges::max(window.pads_end));
  return convolution.groups == 1 && window.kernel == Pair{3, 3} && window.strides == Pair{1, 1} &&
         window.dilations == Pair{1, 1} && to.dims()[0] == 1 && max_pad <= 1 &&
         weights[0] % kBlock == 0 && weights[1] % kBlock == 0 && weights[0] >= kMinOutputs &&
         weights[1] >= kMinChannels && to.dims()[2] >= kMinSide && to.dims()[3] >= kMinSide;
}

// In Winograd's way. oneDNN slices the size of the tiles by the number of threads, too, and other
// tiles round otherwise: the size for one thread is taken at any number.
std::optional<ConvolutionDescription> winograd_convolution(const Convolution& convolution,
                                                           ConvolutionWay way,
                                                           const memory::desc& from,
                                                           const memory::desc& to,
                                                           const dnnl::engine& engine) {
  way.algorithm = algorithm::convolution_winograd;
  {
    const ScopedOmpThreads one(1);
    const auto found = fast_convolution(convolution, way, from, to, engine);
    if (!found) return std::nullopt;
    way.implementation = found->impl_info_str();
  }
  return fast_convolution(convolution, way, from, to, engine);
}

}  // namespace

std::optional<ConvolutionDescription> fast_convolution(const Convolution& convolution,
                                                       const ConvolutionWay& way,
                                                       const memory::desc& from,
                                                       const memory::desc& to,
                                                       const dnnl::engine& engine) {
  try {
    auto description = convolution_in(convolution, way, from, to, engine);
    const std::string name = description.impl_info_str();
    if (name.find("ref") == std::string::npos && name.find("gemm") == std::string::npos)
      return description;
  } catch (const dnnl::error&) {
    // oneDNN has no way at all in these layouts.
  }
  return std::nullopt;
}

ConvolutionDescription choose_convolution(const Convolution& convolution, bool may_use_winograd,
                                          const memory::desc& from, const memory::desc& to,
                                          const dnnl::engine& engine) {
  dnnl::post_ops after;
  if (convolution.adds_residual) after.append_sum(1);
  append_activations(after, convolution.activations);
  ConvolutionWay way;
  way.attributes = user_scratchpad();
  way.attributes.set_post_ops(after);
  if (may_use_winograd && suits_winograd(convolution, to)) {
    if (auto found = winograd_convolution(convolution, way, from, to, engine)) return *found;
  }
  if (auto found = fast_convolution(convolution, way, from, to, engine)) return *found;
  return convolution_in(convolution, way, any_layout(from.dims()), any_layout(to.dims()), engine);
}

}  // namespace roomwise::network
