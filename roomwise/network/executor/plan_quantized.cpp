// How layers are worked out in 8 bits (quantization.h).
#include <algorithm>
#include <cmath>
#include <cstring>

#include "roomwise/network/executor/plan_builder.h"
#include "roomwise/network/executor/quantization.h"

namespace roomwise::network {
namespace {

using dnnl::memory;

// Whether the activations give k * f(x) for k * x.
bool keeps_scale(const Activation& activation) {
  return activation.function == Activation::Function::kRelu;
}

// The step of each output channel's weights. Without VNNI two products of 8 bits are added up in
// 16, where 255 * 127 * 2 does not fit; with 7 bits for the weights 255 * 63 * 2 does.
std::vector<float> weight_steps(const Convolution& convolution, int most) {
  const std::vector<float>& weights = convolution.weights->floats;
  const auto outputs = static_cast<std::size_t>(convolution.weights->shape[0]);
  const std::size_t each = weights.size() / outputs;
  std::vector<float> steps;
  for (std::size_t i = 0; i < outputs; ++i) {
    float largest = 0;
    for (std::size_t j = 0; j < each; ++j)
      largest = std::max(largest, std::abs(weights[i * each + j]));
    steps.push_back(largest > 0 ? largest / static_cast<float>(most) : 1);
  }
  return steps;
}

// Joins along the channels, which lie side by side at each place; sizes in bytes.
Kernel byte_join_kernel(std::vector<std::size_t> channels, std::size_t places) {
  return [channels = std::move(channels), places](std::span<const float* const> sources,
                                                  float* target) -> Expected<void> {
    std::size_t all = 0;
    for (const std::size_t count : channels) all += count;
    auto* to = reinterpret_cast<std::uint8_t*>(target);
    for (std::size_t i = 0; i < sources.size(); ++i) {
      const auto* from = reinterpret_cast<const std::uint8_t*>(sources[i]);
      for (std::size_t place = 0; place < places; ++place)
        std::memcpy(to + place * all, from + place * channels[i], channels[i]);
      to += channels[i];
    }
    return {};
  };
}

}  // namespace

int max_weight_in_eight_bits(dnnl::cpu_isa isa) {
  const auto has = [isa](dnnl::cpu_isa wanted) {
    return (static_cast<unsigned>(isa) & static_cast<unsigned>(wanted)) ==
           static_cast<unsigned>(wanted);
  };
  return has(dnnl::cpu_isa::avx512_core_vnni) || has(dnnl::cpu_isa::avx2_vnni) ? 127 : 63;
}

PlanBuilder::Layout PlanBuilder::in_eight_bits(ValueId value) const {
  const Shape& dims = shape(value);
  return {
      {dims.begin(), dims.end()},
      program_.values[value].eight_bits->is_signed ? memory::data_type::s8 : memory::data_type::u8,
      memory::format_tag::nhwc};
}

// In 8 bits where its value is, else in floats, channels last too. What may be negative, as sums
// and what goes into them, stays exact: it is rounded only where a convolution looks at it.
PlanBuilder::Layout PlanBuilder::quantized_output(const Layer& layer,
                                                  const Convolution& convolution) const {
  const auto& wanted = program_.values[layer.output].eight_bits;
  if (wanted && !wanted->is_signed && !convolution.adds_residual)
    return in_eight_bits(layer.output);
  const Shape& dims = shape(layer.output);
  return {{dims.begin(), dims.end()}, memory::data_type::f32, memory::format_tag::nhwc};
}

bool PlanBuilder::plan_in_eight_bits(const Layer& layer, const Convolution& convolution) {
  const auto& of_input = program_.values[layer.inputs[0]].eight_bits;
  if (!of_input) return false;
  const Layout output = quantized_output(layer, convolution);
  const bool gives_bytes = output.data_type() != memory::data_type::f32;
  const float output_step = gives_bytes ? program_.values[layer.output].eight_bits->step : 1;
  const bool scales_at_once = std::ranges::all_of(convolution.activations, keeps_scale);

  const auto most = max_weight_in_eight_bits(dnnl::get_effective_cpu_isa());
  const std::vector<float> steps = weight_steps(convolution, most);
  std::vector<float> scales, weight_scales, bias;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const float step = of_input->step * steps[i];
    scales.push_back(scales_at_once ? step / output_step : step);
    weight_scales.push_back(1 / steps[i]);
    if (!convolution.bias.empty()) bias.push_back(convolution.bias[i] / step);
  }
  dnnl::post_ops after;
  if (convolution.adds_residual) after.append_sum(1);
  append_activations(after, convolution.activations);
  if (!scales_at_once && gives_bytes)
    after.append_eltwise(1, dnnl::algorithm::eltwise_linear, 1 / output_step, 0);
  dnnl::primitive_attr attributes = user_scratchpad();
  attributes.set_post_ops(after);
  attributes.set_output_scales(1 << 1, scales);
  const auto description = fast_convolution(
      convolution, {dnnl::algorithm::convolution_direct, memory::data_type::s8, attributes},
      in_eight_bits(layer.inputs[0]), output, plan_->engine);
  if (!description) return false;

  dnnl::primitive_attr scaled;
  scaled.set_output_scales(convolution.groups == 1 ? 1 : 3, weight_scales);
  add_convolution(layer, *description,
                  reordered(given_weights(convolution), description->weights_desc(), scaled), bias);
  return true;
}

// Convolutions may look at a layer's input and at its output with steps of their own.
bool PlanBuilder::propagates_eight_bits(const Layer& layer) const {
  const auto& step = program_.values[layer.output].eight_bits;
  return step && preserves_quantization(program_, layer) &&
         std::ranges::all_of(layer.inputs, [&](ValueId input) {
           return program_.values[input].eight_bits == step;
         });
}

void PlanBuilder::join_in_eight_bits(const Layer& layer) {
  std::vector<std::size_t> channels;
  std::vector<TensorView> operands;
  for (const ValueId input : layer.inputs) {
    channels.push_back(static_cast<std::size_t>(shape(input)[1]));
    operands.push_back(in_layout(input, in_eight_bits(input)));
  }
  const Shape& joined = shape(layer.output);
  const auto places = static_cast<std::size_t>(joined[0] * joined[2] * joined[3]);
  operands.push_back(place_output(layer.output, in_eight_bits(layer.output)));
  add_kernel(byte_join_kernel(std::move(channels), places), std::move(operands));
}

}  // namespace roomwise::network
