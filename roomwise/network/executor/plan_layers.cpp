// How each kind of layer becomes calls of oneDNN, or of our own kernels.
#include <algorithm>

#include "roomwise/network/executor/plan_builder.h"

namespace roomwise::network {
namespace {

using dnnl::algorithm;
using dnnl::memory;
using dnnl::prop_kind;

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
    case Arithmetic::Operator::kMaximum:
      return algorithm::binary_max;
    case Arithmetic::Operator::kMinimum:
      return algorithm::binary_min;
    case Arithmetic::Operator::kEqual:
      return algorithm::binary_eq;
    case Arithmetic::Operator::kLess:
      return algorithm::binary_lt;
  }
  return algorithm::binary_add;
}

}  // namespace

void PlanBuilder::plan_layer(const Layer& layer, const Convolution& convolution) {
  if (plan_in_eight_bits(layer, convolution)) return;
  const Shape& from = shape(layer.inputs[0]);
  // A picture of three colours is taken as it is.
  const bool is_picture = convolution.groups == 1 && from[1] <= 3;
  const auto description = choose_convolution(convolution, options_.uses_winograd,
                                              is_picture ? plain(from) : blocked(from),
                                              blocked(shape(layer.output)), plan_->engine);
  add_convolution(layer, description,
                  reordered(given_weights(convolution), description.weights_desc()),
                  convolution.bias);
}

void PlanBuilder::add_convolution(const Layer& layer, const ConvolutionDescription& description,
                                  const memory& weights, const std::vector<float>& bias) {
  std::vector<PlannedOp::Operand> operands{{DNNL_ARG_WEIGHTS, add_constant(weights)}};
  if (!bias.empty()) {
    operands.push_back(
        {DNNL_ARG_BIAS, add_constant(constant_memory(description.bias_desc(), bias))});
  }
  operands.push_back({DNNL_ARG_SRC, in_layout(layer.inputs[0], description.src_desc())});
  operands.push_back({DNNL_ARG_DST, layer.as<Convolution>()->adds_residual
                                        ? residual_in_place(layer, description.dst_desc())
                                        : place_output(layer.output, description.dst_desc())});
  add_primitive(dnnl::convolution_forward(description), description.scratchpad_desc(),
                std::move(operands));
}

dnnl::memory PlanBuilder::given_weights(const Convolution& convolution) const {
  const memory::dims weights = weight_dims(convolution);
  return constant_memory(plain(Shape(weights.begin(), weights.end())), convolution.weights->floats);
}

// oneDNN adds to what lies where it writes. That is the residual itself where nobody reads it
// afterwards, else a copy.
TensorView PlanBuilder::residual_in_place(const Layer& layer, const Layout& layout) {
  const ValueId value = layer.inputs[1];
  const TensorView residual = in_layout(value, layout);
  const bool is_free = last_use_[value] == layer_ && layer.inputs[0] != value &&
                       !shares_memory_[value] && !concats_[value] && !concats_[layer.output] &&
                       !concat_places_.contains(value) && !residual.place.is_constant;
  if (is_free) {
    located_[layer.output] = residual;
    return residual;
  }
  const TensorView output = place_output(layer.output, layout);
  copy(residual, output, 1);
  return output;
}

void PlanBuilder::plan_layer(const Layer& layer, const Pooling& pooling) {
  const Window& window = pooling.window;
  const algorithm way = pooling.kind == Pooling::Kind::kMaximum ? algorithm::pooling_max
                        : pooling.kind == Pooling::Kind::kMean
                            ? algorithm::pooling_avg_exclude_padding
                            : algorithm::pooling_avg_include_padding;
  const bool in_bytes = propagates_eight_bits(layer);
  const auto layout = [&](ValueId value) {
    return in_bytes ? in_eight_bits(value) : blocked(shape(value));
  };
  const TensorView input = in_layout(layer.inputs[0], layout(layer.inputs[0]));
  const dnnl::pooling_forward::primitive_desc description(
      {prop_kind::forward_inference, way, input.layout, layout(layer.output),
       dims_of(window.strides), dims_of(window.kernel), dims_of(window.pads_begin),
       dims_of(window.pads_end)},
      user_scratchpad(), plan_->engine);
  const TensorView output = place_output(layer.output, description.dst_desc());
  add_primitive(dnnl::pooling_forward(description), description.scratchpad_desc(),
                {{DNNL_ARG_SRC, input}, {DNNL_ARG_DST, output}});
}

void PlanBuilder::plan_layer(const Layer& layer, const Activation& activation) {
  if (activation.function == Activation::Function::kErf) {
    add_plain_kernel(layer, erf_kernel(shape(layer.output)));
    return;
  }
  const auto [function, alpha, beta] = elementwise_of(activation);
  const TensorView input = in_floats(layer.inputs[0]);
  const dnnl::eltwise_forward::primitive_desc description(
      {prop_kind::forward_inference, function, input.layout, alpha, beta}, user_scratchpad(),
      plan_->engine);
  const TensorView output = place_output(layer.output, description.dst_desc());
  add_primitive(dnnl::eltwise_forward(description), description.scratchpad_desc(),
                {{DNNL_ARG_SRC, input}, {DNNL_ARG_DST, output}});
}

// oneDNN broadcasts its second input only; what else may broadcast is done row by row.
void PlanBuilder::plan_layer(const Layer& layer, const Arithmetic& arithmetic) {
  const Arithmetic::Operator operation = arithmetic.operation;
  const Shape& result = shape(layer.output);
  ValueId a = layer.inputs[0], b = layer.inputs[1];
  if (arithmetic.commutes() && shape(a) != result) std::swap(a, b);
  if (shape(a) != result || result.empty()) {
    const TensorView of_a = in_layout(a, plain(shape(a))), of_b = in_layout(b, plain(shape(b)));
    const TensorView output = place_output(layer.output, plain(result));
    add_kernel(arithmetic_kernel(operation, shape(a), shape(b), result), {of_a, of_b, output});
    return;
  }
  const bool in_blocks = is_blocked(a) || (result.size() == 4 && is_blocked(b));
  const TensorView of_a = in_layout(a, in_blocks ? blocked(result) : plain(result));
  const bool blocks_of_b = in_blocks && shape(b)[1] != 1;
  const TensorView of_b = in_layout(b, blocks_of_b ? blocked(shape(b)) : plain(shape(b)));
  const dnnl::binary::primitive_desc description(
      {algorithm_of(operation), of_a.layout, of_b.layout, of_a.layout}, user_scratchpad(),
      plan_->engine);
  const TensorView output = place_output(layer.output, of_a.layout);
  add_primitive(dnnl::binary(description), description.scratchpad_desc(),
                {{DNNL_ARG_SRC_0, of_a}, {DNNL_ARG_SRC_1, of_b}, {DNNL_ARG_DST, output}});
}

void PlanBuilder::plan_layer(const Layer& layer, const AxisSlices& gather) {
  if (propagates_eight_bits(layer)) {
    join_in_eight_bits(layer);
    return;
  }
  if (concat_places_.contains(layer.output)) {
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
  std::vector<TensorView> operands;
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
    const TensorView wanted{part, usual(shape(input))};
    const TensorView present = located(input);
    if (!(present.place == wanted.place && present.layout == wanted.layout))
      copy(present, wanted, scale_between(input, present.layout, wanted.layout));
    part.offset += element_count(shape(input)) * sizeof(float);
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
  const dnnl::matmul::primitive_desc description({of_a, of_b, bias, result}, user_scratchpad(),
                                                 plan_->engine);
  std::vector<PlannedOp::Operand> operands{
      {DNNL_ARG_SRC, in_layout(a, of_a)},
      {DNNL_ARG_WEIGHTS, in_layout(b, description.weights_desc())}};
  if (!product.bias.empty())
    operands.push_back({DNNL_ARG_BIAS, add_constant(constant_memory(bias, product.bias))});
  operands.push_back({DNNL_ARG_DST, place_output(layer.output, result)});
  add_primitive(dnnl::matmul(description), description.scratchpad_desc(), std::move(operands));
}

void PlanBuilder::plan_layer(const Layer& layer, const Softmax& softmax) {
  const TensorView input = in_layout(layer.inputs[0], plain(shape(layer.inputs[0])));
  const dnnl::softmax_forward::primitive_desc description(
      {prop_kind::forward_inference, input.layout, static_cast<int>(softmax.axis)},
      user_scratchpad(), plan_->engine);
  const TensorView output = place_output(layer.output, input.layout);
  add_primitive(dnnl::softmax_forward(description), description.scratchpad_desc(),
                {{DNNL_ARG_SRC, input}, {DNNL_ARG_DST, output}});
}

void PlanBuilder::plan_layer(const Layer& layer, const Resampling& resampling) {
  const ValueId from = layer.inputs[0];
  const bool in_blocks = is_blocked(from);
  const TensorView input = in_layout(from, in_blocks ? blocked(shape(from)) : plain(shape(from)));
  const Shape& result = shape(layer.output);
  const TensorView output = place_output(layer.output, in_blocks ? blocked(result) : plain(result));
  add_kernel(resampling_kernel(resampling, shape(from), in_blocks ? block_ : 1), {input, output});
}

void PlanBuilder::plan_layer(const Layer& layer, const View&) {
  const ValueId from = layer.inputs[0];
  located_[layer.output] =
      TensorView{in_layout(from, plain(shape(from))).place, plain(shape(layer.output))};
  shares_memory_[from] = shares_memory_[layer.output] = true;
}

// A reordering from a layout that says the axes in another order.
void PlanBuilder::plan_layer(const Layer& layer, const Permutation& permutation) {
  const ValueId from = layer.inputs[0];
  const TensorView input = in_layout(from, plain(shape(from)));
  const TensorView output = place_output(layer.output, plain(shape(layer.output)));
  std::vector<int> places(permutation.axes.size());
  for (std::size_t i = 0; i < places.size(); ++i) places[permutation.axes[i]] = static_cast<int>(i);
  copy({input.place, input.layout.permute_axes(places)}, output, 1);
}

void PlanBuilder::plan_layer(const Layer& layer, const Mean& mean) {
  add_plain_kernel(layer, mean_kernel(mean, shape(layer.inputs[0])));
}

void PlanBuilder::plan_layer(const Layer& layer, const Where&) {
  add_plain_kernel(layer, selection_kernel(shape(layer.inputs[0]), shape(layer.inputs[1]),
                                           shape(layer.inputs[2]), shape(layer.output)));
}

void PlanBuilder::plan_layer(const Layer& layer, const Gather& lookup) {
  add_plain_kernel(layer, lookup_kernel(lookup, shape(layer.inputs[0]),
                                        element_count(shape(layer.inputs[1])), layer.node));
}

void PlanBuilder::plan_layer(const Layer& layer, const ArgMax& largest) {
  add_plain_kernel(layer, largest_index_kernel(largest, shape(layer.inputs[0])));
}

void PlanBuilder::add_plain_kernel(const Layer& layer, Kernel kernel) {
  std::vector<TensorView> operands;
  for (const ValueId input : layer.inputs)
    operands.push_back(in_layout(input, plain(shape(input))));
  operands.push_back(place_output(layer.output, plain(shape(layer.output))));
  add_kernel(std::move(kernel), std::move(operands));
}

}  // namespace roomwise::network
