// How each kind of layer becomes calls of oneDNN, or of our own kernels.
#include <algorithm>
#include <optional>

#include "roomwise/network/plan_builder.h"

namespace roomwise::network {
namespace {

using dnnl::algorithm;
using dnnl::memory;
using dnnl::prop_kind;

struct Elementwise {
  algorithm function;
  float alpha;
  float beta;
};

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
    case Activation::Function::kLinear:
      return {algorithm::eltwise_linear, alpha, beta};
    case Activation::Function::kSwish:
      return {algorithm::eltwise_swish, 1, 0};
    case Activation::Function::kHardSwish:
      return {algorithm::eltwise_hardswish, 0, 0};
  }
  return {algorithm::eltwise_relu, 0, 0};
}

// The memory that a primitive works in is part of the plan's: primitives are shared by threads.
dnnl::primitive_attr attributes() {
  dnnl::primitive_attr attributes;
  attributes.set_scratchpad_mode(dnnl::scratchpad_mode::user);
  return attributes;
}

dnnl::primitive_attr attributes_of(const Convolution& convolution) {
  dnnl::post_ops after;
  if (convolution.adds_residual) after.append_sum(1);
  for (const Activation& activation : convolution.activations) {
    const auto [function, alpha, beta] = elementwise_of(activation);
    after.append_eltwise(1, function, alpha, beta);
  }
  dnnl::primitive_attr result = attributes();
  result.set_post_ops(after);
  return result;
}

memory::dims dims(const std::array<std::int64_t, 2>& pair) {
  return {pair[0], pair[1]};
}

memory::desc any_layout(const memory::dims& dims) {
  return {dims, memory::data_type::f32, memory::format_tag::any};
}

memory::dims weight_dims(const Convolution& convolution) {
  const Shape& shape = convolution.weights->shape;
  if (convolution.groups == 1) return {shape.begin(), shape.end()};
  return {convolution.groups, shape[0] / convolution.groups, shape[1], shape[2], shape[3]};
}

dnnl::convolution_forward::primitive_desc convolution_in(const Convolution& convolution,
                                                         algorithm way, const memory::desc& from,
                                                         const memory::desc& to,
                                                         const dnnl::engine& engine) {
  const Window& window = convolution.window;
  // oneDNN counts the places between a window's places.
  const memory::dims dilations{window.dilations[0] - 1, window.dilations[1] - 1};
  const auto outputs = convolution.weights->shape[0];
  const memory::desc bias = convolution.bias.empty() ? memory::desc() : any_layout({outputs});
  const dnnl::convolution_forward::desc description(
      prop_kind::forward_inference, way, from, any_layout(weight_dims(convolution)), bias, to,
      dims(window.strides), dilations, dims(window.pads_begin), dims(window.pads_end));
  return {description, attributes_of(convolution), engine};
}

// Whether Winograd's way (tiles of 2x2 places, 2.25 times fewer multiplications) is the faster one:
// as measured (docs/benchmarks.md), which says it by the shape alone, so that the choice, and with
// it the bits, are the same on every machine that has both.
bool suits_winograd(const Convolution& convolution, const memory::desc& to) {
  constexpr std::int64_t kLeastChannels = 32, kLeastOutputs = 48, kLeastSide = 12;
  using Pair = std::array<std::int64_t, 2>;
  const Window& window = convolution.window;
  const Shape& weights = convolution.weights->shape;
  return convolution.groups == 1 && window.kernel == Pair{3, 3} && window.strides == Pair{1, 1} &&
         window.dilations == Pair{1, 1} && weights[0] >= kLeastOutputs &&
         weights[1] >= kLeastChannels && to.dims()[2] >= kLeastSide && to.dims()[3] >= kLeastSide;
}

using ConvolutionWay = dnnl::convolution_forward::primitive_desc;

// In these layouts; absent where oneDNN has no fast way for them.
std::optional<ConvolutionWay> fast_convolution(const Convolution& convolution, algorithm way,
                                               const memory::desc& from, const memory::desc& to,
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

// In the layouts of feature maps where oneDNN has a fast way for them, else in those that it
// chooses.
ConvolutionWay choose_convolution(const Convolution& convolution, bool may_use_winograd,
                                  const memory::desc& from, const memory::desc& to,
                                  const dnnl::engine& engine) {
  if (may_use_winograd && suits_winograd(convolution, to)) {
    if (auto found =
            fast_convolution(convolution, algorithm::convolution_winograd, from, to, engine))
      return *found;
  }
  if (auto found = fast_convolution(convolution, algorithm::convolution_direct, from, to, engine))
    return *found;
  return convolution_in(convolution, algorithm::convolution_direct, any_layout(from.dims()),
                        any_layout(to.dims()), engine);
}

algorithm algorithm_of(Arithmetic::Operator operation) {
  switch (operation) {
    case Arithmetic::Operator::kAdd:
      return algorithm::binary_add;
    case Arithmetic::Operator::kSubtract:
      return algorithm::binary_sub;
    case Arithmetic::Operator::kMultiply:
      return algorithm::binary_mul;
    case Arithmetic::Operator::kDivide:
      return algorithm::binary_div;
  }
  return algorithm::binary_add;
}

}  // namespace

void PlanBuilder::plan_layer(const Layer& layer, const Convolution& convolution) {
  const Shape& from = shape(layer.inputs[0]);
  // A picture of three colours is taken as it is.
  const bool is_picture = convolution.groups == 1 && from[1] <= 3;
  const auto description = choose_convolution(convolution, options_.uses_winograd,
                                              is_picture ? plain(from) : blocked(from),
                                              blocked(shape(layer.output)), plan_->engine);
  std::vector<Step::Operand> operands;
  const memory::dims weights = weight_dims(convolution);
  const memory given =
      constant_memory(plain(Shape(weights.begin(), weights.end())), convolution.weights->floats);
  operands.push_back(
      {DNNL_ARG_WEIGHTS, add_constant(reordered(given, description.weights_desc()))});
  if (!convolution.bias.empty()) {
    operands.push_back(
        {DNNL_ARG_BIAS, add_constant(constant_memory(description.bias_desc(), convolution.bias))});
  }
  operands.push_back({DNNL_ARG_SRC, in_layout(layer.inputs[0], description.src_desc())});
  const Located output = convolution.adds_residual
                             ? residual_in_place(layer, description.dst_desc())
                             : place_output(layer.output, description.dst_desc());
  operands.push_back({DNNL_ARG_DST, output});
  add_primitive(dnnl::convolution_forward(description), description.scratchpad_desc(),
                std::move(operands));
}

// oneDNN adds to what lies where it writes. That is the residual itself where nobody reads it
// afterwards, else a copy.
Located PlanBuilder::residual_in_place(const Layer& layer, const Layout& layout) {
  const ValueId value = layer.inputs[1];
  const Located residual = in_layout(value, layout);
  const bool is_free = last_use_[value] == layer_ && layer.inputs[0] != value &&
                       !shares_memory_[value] && !joins_[value] && !joins_[layer.output] &&
                       !join_places_.contains(value) && !residual.place.is_constant;
  if (is_free) {
    located_[layer.output] = residual;
    return residual;
  }
  const Located output = place_output(layer.output, layout);
  copy(residual, output);
  return output;
}

void PlanBuilder::plan_layer(const Layer& layer, const Pooling& pooling) {
  const Window& window = pooling.window;
  const algorithm way = pooling.kind == Pooling::Kind::kMaximum ? algorithm::pooling_max
                        : pooling.kind == Pooling::Kind::kMean
                            ? algorithm::pooling_avg_exclude_padding
                            : algorithm::pooling_avg_include_padding;
  const Located input = in_layout(layer.inputs[0], blocked(shape(layer.inputs[0])));
  const dnnl::pooling_forward::primitive_desc description(
      {prop_kind::forward_inference, way, input.layout, blocked(shape(layer.output)),
       dims(window.strides), dims(window.kernel), dims(window.pads_begin), dims(window.pads_end)},
      attributes(), plan_->engine);
  const Located output = place_output(layer.output, description.dst_desc());
  add_primitive(dnnl::pooling_forward(description), description.scratchpad_desc(),
                {{DNNL_ARG_SRC, input}, {DNNL_ARG_DST, output}});
}

void PlanBuilder::plan_layer(const Layer& layer, const Activation& activation) {
  const auto [function, alpha, beta] = elementwise_of(activation);
  const Located input = located(layer.inputs[0]);
  const dnnl::eltwise_forward::primitive_desc description(
      {prop_kind::forward_inference, function, input.layout, alpha, beta}, attributes(),
      plan_->engine);
  const Located output = place_output(layer.output, description.dst_desc());
  add_primitive(dnnl::eltwise_forward(description), description.scratchpad_desc(),
                {{DNNL_ARG_SRC, input}, {DNNL_ARG_DST, output}});
}

// oneDNN broadcasts its second input only; what else may broadcast is done row by row.
void PlanBuilder::plan_layer(const Layer& layer, const Arithmetic& arithmetic) {
  const Arithmetic::Operator operation = arithmetic.operation;
  const Shape& result = shape(layer.output);
  ValueId a = layer.inputs[0], b = layer.inputs[1];
  const bool commutes =
      operation == Arithmetic::Operator::kAdd || operation == Arithmetic::Operator::kMultiply;
  if (commutes && shape(a) != result) std::swap(a, b);
  if (shape(a) != result || result.empty()) {
    const Located of_a = in_layout(a, plain(shape(a))), of_b = in_layout(b, plain(shape(b)));
    const Located output = place_output(layer.output, plain(result));
    add_kernel(arithmetic_kernel(operation, shape(a), shape(b), result), {of_a, of_b, output});
    return;
  }
  const bool in_blocks = is_blocked(a) || (result.size() == 4 && is_blocked(b));
  const Located of_a = in_layout(a, in_blocks ? blocked(result) : plain(result));
  const bool blocks_of_b = in_blocks && shape(b)[1] != 1;
  const Located of_b = in_layout(b, blocks_of_b ? blocked(shape(b)) : plain(shape(b)));
  const dnnl::binary::primitive_desc description(
      {algorithm_of(operation), of_a.layout, of_b.layout, of_a.layout}, attributes(),
      plan_->engine);
  const Located output = place_output(layer.output, of_a.layout);
  add_primitive(dnnl::binary(description), description.scratchpad_desc(),
                {{DNNL_ARG_SRC_0, of_a}, {DNNL_ARG_SRC_1, of_b}, {DNNL_ARG_DST, output}});
}

void PlanBuilder::plan_layer(const Layer& layer, const AxisGather& gather) {
  if (join_places_.contains(layer.output)) {
    gather_in_place(layer);
    return;
  }
  const bool in_blocks = gather.axis == 1 && std::ranges::any_of(layer.inputs, [&](ValueId input) {
                           return is_blocked(input);
                         });
  const auto layout = [&](ValueId value) {
    return in_blocks ? blocked(shape(value)) : plain(shape(value));
  };
  const auto around_axis = [&](ValueId value) {
    return BlockedShape::around(shape(value), gather.axis, in_blocks ? block_ : 1);
  };
  std::vector<BlockedShape> shapes;
  std::vector<Located> operands;
  for (const ValueId input : layer.inputs) {
    shapes.push_back(around_axis(input));
    operands.push_back(in_layout(input, layout(input)));
  }
  operands.push_back(place_output(layer.output, layout(layer.output)));
  add_kernel(gather_kernel(gather, std::move(shapes), around_axis(layer.output)),
             std::move(operands));
}

// Most of what is joined lies there already.
void PlanBuilder::gather_in_place(const Layer& layer) {
  const Place whole = place_of_join(layer.output);
  Place part = whole;
  for (const ValueId input : layer.inputs) {
    const Located wanted{part, usual(shape(input))};
    const Located present = located(input);
    if (!(present.place == wanted.place && present.layout == wanted.layout)) copy(present, wanted);
    part.offset += count_of(shape(input)) * sizeof(float);
  }
}

void PlanBuilder::plan_layer(const Layer& layer, const MatrixProduct& product) {
  const ValueId a = layer.inputs[0], b = layer.inputs[1];
  const bool packs = program_.values[b].constant != nullptr;
  const Layout of_a = plain(shape(a)), result = plain(shape(layer.output));
  const Layout of_b = packs ? any_layout(plain(shape(b)).dims()) : plain(shape(b));
  Shape bias_shape(shape(layer.output).size(), 1);
  bias_shape.back() = shape(layer.output).back();
  const Layout bias = product.bias.empty() ? Layout() : plain(bias_shape);
  const dnnl::matmul::primitive_desc description({of_a, of_b, bias, result}, attributes(),
                                                 plan_->engine);
  std::vector<Step::Operand> operands{{DNNL_ARG_SRC, in_layout(a, of_a)},
                                      {DNNL_ARG_WEIGHTS, in_layout(b, description.weights_desc())}};
  if (!product.bias.empty())
    operands.push_back({DNNL_ARG_BIAS, add_constant(constant_memory(bias, product.bias))});
  operands.push_back({DNNL_ARG_DST, place_output(layer.output, result)});
  add_primitive(dnnl::matmul(description), description.scratchpad_desc(), std::move(operands));
}

void PlanBuilder::plan_layer(const Layer& layer, const Softmax& softmax) {
  const Located input = in_layout(layer.inputs[0], plain(shape(layer.inputs[0])));
  const dnnl::softmax_forward::primitive_desc description(
      {prop_kind::forward_inference, input.layout, static_cast<int>(softmax.axis)}, attributes(),
      plan_->engine);
  const Located output = place_output(layer.output, input.layout);
  add_primitive(dnnl::softmax_forward(description), description.scratchpad_desc(),
                {{DNNL_ARG_SRC, input}, {DNNL_ARG_DST, output}});
}

void PlanBuilder::plan_layer(const Layer& layer, const Resampling& resampling) {
  const ValueId from = layer.inputs[0];
  const bool in_blocks = is_blocked(from);
  const Located input = in_layout(from, in_blocks ? blocked(shape(from)) : plain(shape(from)));
  const Shape& result = shape(layer.output);
  const Located output = place_output(layer.output, in_blocks ? blocked(result) : plain(result));
  add_kernel(resampling_kernel(resampling, shape(from), in_blocks ? block_ : 1), {input, output});
}

void PlanBuilder::plan_layer(const Layer& layer, const View&) {
  const ValueId from = layer.inputs[0];
  located_[layer.output] =
      Located{in_layout(from, plain(shape(from))).place, plain(shape(layer.output))};
  shares_memory_[from] = shares_memory_[layer.output] = true;
}

// A reordering from a layout that says the axes in another order.
void PlanBuilder::plan_layer(const Layer& layer, const Permutation& permutation) {
  const ValueId from = layer.inputs[0];
  const Located input = in_layout(from, plain(shape(from)));
  const Located output = place_output(layer.output, plain(shape(layer.output)));
  std::vector<int> places(permutation.axes.size());
  for (std::size_t i = 0; i < places.size(); ++i) places[permutation.axes[i]] = static_cast<int>(i);
  copy({input.place, input.layout.permute_axes(places)}, output);
}

void PlanBuilder::plan_layer(const Layer& layer, const Mean& mean) {
  const ValueId from = layer.inputs[0];
  const Located input = in_layout(from, plain(shape(from)));
  const Located output = place_output(layer.output, plain(shape(layer.output)));
  add_kernel(mean_kernel(mean, shape(from)), {input, output});
}

}  // namespace roomwise::network
