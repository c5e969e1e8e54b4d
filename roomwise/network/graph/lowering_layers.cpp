// Convolutions, pooling, element-wise functions.
#include <algorithm>
#include <cmath>
#include <limits>

#include "roomwise/network/graph/lowering.h"

namespace roomwise::network {
namespace {

using Function = Activation::Function;
using Operator = Arithmetic::Operator;

constexpr std::int64_t kMaxWindow = 1 << 16;

Expected<std::array<std::int64_t, 2>> pair_of(const Node& node, const std::string& attribute,
                                              std::array<std::int64_t, 2> otherwise) {
  const auto values = node.integers(attribute, {otherwise[0], otherwise[1]});
  if (values.size() != 2 || values[0] < 1 || values[1] < 1 || values[0] > kMaxWindow ||
      values[1] > kMaxWindow) {
    return fail("expected two numbers above 0 as {}", attribute);
  }
  return std::array{values[0], values[1]};
}

// Kernel, strides, dilations and pads of the node for an input of `shape`.
Expected<Window> window_of(const Node& node, const Shape& shape,
                           std::array<std::int64_t, 2> kernel) {
  if (shape.size() != 4) {
    return fail("takes pictures (batch x channels x height x width), not {}", shape_text(shape));
  }
  Window window;
  ROOMWISE_TRY(window.kernel, pair_of(node, "kernel_shape", kernel));
  ROOMWISE_TRY(window.strides, pair_of(node, "strides", {1, 1}));
  ROOMWISE_TRY(window.dilations, pair_of(node, "dilations", {1, 1}));
  const auto pads = node.integers("pads", {0, 0, 0, 0});
  const auto usable = [](std::int64_t pad) { return pad >= 0 && pad < kMaxWindow; };
  if (pads.size() != 4 || !std::ranges::all_of(pads, usable)) {
    return fail("expected four numbers from 0 as pads");
  }
  window.pads_begin = {pads[0], pads[1]};
  window.pads_end = {pads[2], pads[3]};
  const std::string automatic = node.text("auto_pad", "NOTSET");
  constexpr std::array kKnown{"NOTSET", "VALID", "SAME_UPPER", "SAME_LOWER"};
  if (std::ranges::find(kKnown, automatic) == kKnown.end()) {
    return fail("its auto_pad \"{}\" is none of {}", automatic, fmt::join(kKnown, ", "));
  }
  if (automatic == "VALID") window.pads_begin = window.pads_end = {0, 0};
  for (std::size_t i = 0; i < 2 && automatic.starts_with("SAME"); ++i) {
    const std::int64_t size = shape[2 + i];
    const std::int64_t outputs = (size + window.strides[i] - 1) / window.strides[i];
    const std::int64_t reach = (window.kernel[i] - 1) * window.dilations[i] + 1;
    const std::int64_t missing =
        std::max<std::int64_t>(0, (outputs - 1) * window.strides[i] + reach - size);
    const std::int64_t less = missing / 2;
    window.pads_begin[i] = automatic == "SAME_LOWER" ? missing - less : less;
    window.pads_end[i] = missing - window.pads_begin[i];
  }
  return window;
}

// Height and width after the window has moved over the input; with `ceil`, a last window that
// begins inside counts too, and the pads grow to hold it.
Expected<std::array<std::int64_t, 2>> moved_over(Window& window, const Shape& shape, bool ceil) {
  std::array<std::int64_t, 2> sizes{};
  for (std::size_t i = 0; i < 2; ++i) {
    const std::int64_t reach = (window.kernel[i] - 1) * window.dilations[i] + 1;
    const std::int64_t padded = shape[2 + i] + window.pads_begin[i] + window.pads_end[i];
    if (padded < reach) {
      return fail("its window of {} is larger than its input {}", reach, shape_text(shape));
    }
    const std::int64_t stride = window.strides[i];
    sizes[i] = (padded - reach) / stride + 1;
    if (ceil && (padded - reach) % stride != 0 &&
        sizes[i] * stride < shape[2 + i] + window.pads_begin[i]) {
      window.pads_end[i] += sizes[i] * stride + reach - padded;
      ++sizes[i];
    }
  }
  return sizes;
}

Expected<ValueId> lower_convolution(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId input, lowering.input(node, 0));
  Convolution convolution;
  ROOMWISE_TRY(convolution.weights, lowering.constant_input(node, 1));
  const Shape& weights = convolution.weights->shape;
  const Shape shape = lowering.shape(input);
  convolution.groups = node.integer("group", 1);
  const std::int64_t groups = convolution.groups;
  if (weights.size() != 4 || convolution.weights->is_integer) {
    return fail("expected weights of four sizes, not {}", shape_text(weights));
  }
  ROOMWISE_TRY(convolution.window, window_of(node, shape, {weights[2], weights[3]}));
  if (convolution.window.kernel != std::array{weights[2], weights[3]} || groups < 1 ||
      groups > weights[0] || weights[0] % groups != 0 || shape[1] % groups != 0 ||
      shape[1] / groups != weights[1]) {
    return fail("its weights {} do not fit its input {} in {} groups", shape_text(weights),
                shape_text(shape), groups);
  }
  if (lowering.has_input(node, 2)) {
    ROOMWISE_TRY(convolution.bias, lowering.floats_input(node, 2));
    if (convolution.bias.size() != static_cast<std::size_t>(weights[0])) {
      return fail("has {} biases for {} outputs", convolution.bias.size(), weights[0]);
    }
  }
  ROOMWISE_TRY(const auto sizes, moved_over(convolution.window, shape, false));
  return lowering.add(std::move(convolution), {input}, {shape[0], weights[0], sizes[0], sizes[1]});
}

Expected<ValueId> lower_pooling(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId input, lowering.input(node, 0));
  const Shape shape = lowering.shape(input);
  Pooling pooling;
  if (node.find("kernel_shape") == nullptr) return fail("lacks its kernel_shape");
  ROOMWISE_TRY(pooling.window, window_of(node, shape, {1, 1}));
  // oneDNN knows the window's size alone, and takes some of these as if they were not dilated.
  if (pooling.window.dilations != std::array<std::int64_t, 2>{1, 1}) {
    return fail("its dilations of {} are not supported; 1 is",
                fmt::join(pooling.window.dilations, " and "));
  }
  const bool ceil = node.integer("ceil_mode", 0) != 0;
  if (node.operation == "AveragePool") {
    const bool counts_pads = node.integer("count_include_pad", 0) != 0;
    pooling.kind = counts_pads ? Pooling::Kind::kMeanIncludingPadding : Pooling::Kind::kMean;
    if (counts_pads && ceil) return fail("ceil_mode with count_include_pad is not supported");
  }
  if (node.outputs.size() > 1 && !node.outputs[1].empty()) {
    return fail("the indices of a maximum are not supported");
  }
  ROOMWISE_TRY(const auto sizes, moved_over(pooling.window, shape, ceil));
  for (std::size_t i = 0; i < 2; ++i) {
    if (pooling.window.pads_begin[i] >= pooling.window.kernel[i])
      return fail("its pads are larger than its window");
  }
  return lowering.add(pooling, {input}, {shape[0], shape[1], sizes[0], sizes[1]});
}

// Without these axes, which have the size 1.
Expected<ValueId> squeezed(Lowering& lowering, ValueId value, std::span<const std::size_t> axes) {
  const Shape shape = lowering.shape(value);
  Shape kept;
  for (std::size_t axis = 0; axis < shape.size(); ++axis) {
    if (std::ranges::find(axes, axis) == axes.end()) kept.push_back(shape[axis]);
  }
  return lowering.reshape(value, kept);
}

// Means, sums and lengths over some axes.
Expected<ValueId> lower_reduction(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(ValueId value, lowering.input(node, 0));
  const Shape shape = lowering.shape(value);
  std::vector<std::size_t> axes;
  bool keeps = true;
  if (node.operation == "GlobalAveragePool") {
    for (std::size_t axis = 2; axis < shape.size(); ++axis) axes.push_back(axis);
  } else {
    keeps = node.integer("keepdims", 1) != 0;
    std::vector<std::int64_t> given = node.integers("axes", {});
    const bool by_input = lowering.has_input(node, 1);  // of a ReduceSum since opset 13
    if (by_input) {
      ROOMWISE_TRY(given, lowering.integers_input(node, 1));
    }
    if (given.empty() && node.integer("noop_with_empty_axes", 0) != 0) return value;
    ROOMWISE_TRY(axes, axes_of(given, shape.size()));
    const bool takes_all = given.empty() && (by_input || node.find("axes") == nullptr);
    for (std::size_t axis = 0; axis < shape.size() && takes_all; ++axis) axes.push_back(axis);
  }
  if (node.operation == "ReduceL2") {
    ROOMWISE_TRY(value, lowering.arithmetic(Operator::kMultiply, value, value));
  }
  ROOMWISE_TRY(value, lowering.mean(value, axes));
  if (node.operation == "ReduceSum" || node.operation == "ReduceL2") {
    double count = 1;
    for (const std::size_t axis : axes) count *= static_cast<double>(shape[axis]);
    const ValueId factor = lowering.add_number(static_cast<float>(count));
    ROOMWISE_TRY(value, lowering.arithmetic(Operator::kMultiply, value, factor));
  }
  if (node.operation == "ReduceL2") {
    const Shape reduced = lowering.shape(value);
    ROOMWISE_TRY(value, lowering.add(Activation{Function::kSquareRoot, 0, 0}, {value}, reduced));
  }
  if (!keeps) {
    ROOMWISE_TRY(value, squeezed(lowering, value, axes));
  }
  return value;
}

// The place of the largest value along an axis.
Expected<ValueId> lower_largest_index(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId input, lowering.input(node, 0));
  Shape shape = lowering.shape(input);
  if (node.integer("select_last_index", 0) != 0)
    return fail("the last of several largest values is not supported; the first is");
  ROOMWISE_TRY(const std::size_t axis, axis_of(node.integer("axis", 0), shape.size()));
  shape[axis] = 1;
  ROOMWISE_TRY(ValueId output, lowering.add(ArgMax{axis}, {input}, shape));
  if (node.integer("keepdims", 1) == 0) {
    ROOMWISE_TRY(output, squeezed(lowering, output, {&axis, 1}));
  }
  return output;
}

// From the axis on to the mean 0 and the variance 1, then a scale and a shift.
Expected<ValueId> lower_layer_normalization(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId input, lowering.input(node, 0));
  ROOMWISE_TRY(const ValueId scale, lowering.input(node, 1));
  for (std::size_t i = 1; i < node.outputs.size(); ++i) {
    if (!node.outputs[i].empty()) return fail("its mean and deviation are not supported");
  }
  const Shape shape = lowering.shape(input);
  ROOMWISE_TRY(const std::size_t first, axis_of(node.integer("axis", -1), shape.size()));
  std::vector<std::size_t> axes;
  for (std::size_t axis = first; axis < shape.size(); ++axis) axes.push_back(axis);
  ROOMWISE_TRY(const ValueId mean, lowering.mean(input, axes));
  ROOMWISE_TRY(const ValueId centered, lowering.arithmetic(Operator::kSubtract, input, mean));
  ROOMWISE_TRY(const ValueId squares, lowering.arithmetic(Operator::kMultiply, centered, centered));
  ROOMWISE_TRY(const ValueId variance, lowering.mean(squares, axes));
  ROOMWISE_TRY(const ValueId raised,
               lowering.arithmetic(Operator::kAdd, variance,
                                   lowering.add_number(node.number("epsilon", 1e-5F))));
  const Shape reduced = lowering.shape(raised);
  ROOMWISE_TRY(const ValueId deviation,
               lowering.add(Activation{Function::kSquareRoot, 0, 0}, {raised}, reduced));
  ROOMWISE_TRY(const ValueId normal, lowering.arithmetic(Operator::kDivide, centered, deviation));
  ROOMWISE_TRY(ValueId output, lowering.arithmetic(Operator::kMultiply, normal, scale));
  if (lowering.has_input(node, 2)) {
    ROOMWISE_TRY(const ValueId shift, lowering.input(node, 2));
    ROOMWISE_TRY(output, lowering.arithmetic(Operator::kAdd, output, shift));
  }
  if (lowering.shape(output) != shape)
    return fail("its numbers do not fit its input {}", shape_text(shape));
  return output;
}

// As a scale and a shift a channel; passes put them into the convolution before.
Expected<ValueId> lower_batch_normalization(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId input, lowering.input(node, 0));
  ROOMWISE_TRY(const std::vector<float> gains, lowering.floats_input(node, 1));
  ROOMWISE_TRY(const std::vector<float> shifts, lowering.floats_input(node, 2));
  ROOMWISE_TRY(const std::vector<float> means, lowering.floats_input(node, 3));
  ROOMWISE_TRY(const std::vector<float> variances, lowering.floats_input(node, 4));
  const Shape& shape = lowering.shape(input);
  const std::size_t channels = gains.size();
  if (shape.size() < 2 || static_cast<std::size_t>(shape[1]) != channels ||
      shifts.size() != channels || means.size() != channels || variances.size() != channels) {
    return fail("its numbers do not fit its input {}", shape_text(shape));
  }
  if (node.integer("training_mode", 0) != 0) return fail("is meant for training");
  const float epsilon = node.number("epsilon", 1e-5F);
  Constant scale, shift;
  scale.shape = Shape(shape.size(), 1);
  scale.shape[1] = shape[1];
  shift.shape = scale.shape;
  for (std::size_t i = 0; i < channels; ++i) {
    const double factor = gains[i] / std::sqrt(static_cast<double>(variances[i]) + epsilon);
    scale.floats.push_back(static_cast<float>(factor));
    shift.floats.push_back(static_cast<float>(shifts[i] - means[i] * factor));
  }
  ROOMWISE_TRY(const ValueId scaled, lowering.arithmetic(Operator::kMultiply, input,
                                                         lowering.add_constant(std::move(scale))));
  return lowering.arithmetic(Operator::kAdd, scaled, lowering.add_constant(std::move(shift)));
}

// One limit of a Clip: an attribute before opset 11, an input since.
Expected<float> limit_of(Lowering& lowering, const Node& node, std::size_t i,
                         const std::string& attribute, float otherwise) {
  if (lowering.opset() < 11) return node.number(attribute, otherwise);
  if (!lowering.has_input(node, i)) return otherwise;
  ROOMWISE_TRY(const std::vector<float> values, lowering.floats_input(node, i));
  if (values.size() != 1) return fail("expected a single number as limit");
  return values.front();
}

Expected<std::vector<Activation>> activations_of(Lowering& lowering, const Node& node) {
  const std::string& name = node.operation;
  constexpr float kLargest = std::numeric_limits<float>::max();
  if (name == "Relu") return std::vector{Activation{Function::kRelu, 0, 0}};
  if (name == "LeakyRelu") {
    return std::vector{Activation{Function::kRelu, node.number("alpha", 0.01F), 0}};
  }
  if (name == "Sigmoid") return std::vector{Activation{Function::kSigmoid, 0, 0}};
  if (name == "Tanh") return std::vector{Activation{Function::kTanh, 0, 0}};
  if (name == "Exp") return std::vector{Activation{Function::kExp, 0, 0}};
  if (name == "Sqrt") return std::vector{Activation{Function::kSquareRoot, 0, 0}};
  if (name == "Erf") return std::vector{Activation{Function::kErf, 0, 0}};
  if (name == "HardSwish") return std::vector{Activation{Function::kHardSwish, 0, 0}};
  if (name == "HardSigmoid") {
    return std::vector{
        Activation{Function::kLinear, node.number("alpha", 0.2F), node.number("beta", 0.5F)},
        Activation{Function::kClip, 0, 1}};
  }
  ROOMWISE_TRY(const float low, limit_of(lowering, node, 1, "min", -kLargest));
  ROOMWISE_TRY(const float high, limit_of(lowering, node, 2, "max", kLargest));
  return std::vector{Activation{Function::kClip, low, high}};
}

Expected<ValueId> lower_activation(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(ValueId value, lowering.input(node, 0));
  ROOMWISE_TRY(const std::vector<Activation> activations, activations_of(lowering, node));
  for (const Activation& activation : activations) {
    const Shape shape = lowering.shape(value);
    ROOMWISE_TRY(value, lowering.add(activation, {value}, shape));
  }
  return value;
}

template <Operator operation>
Expected<ValueId> lower_arithmetic(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId a, lowering.input(node, 0));
  ROOMWISE_TRY(const ValueId b, lowering.input(node, 1));
  return lowering.arithmetic(operation, a, b);
}

Expected<ValueId> lower_greater(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId a, lowering.input(node, 0));
  ROOMWISE_TRY(const ValueId b, lowering.input(node, 1));
  return lowering.arithmetic(Operator::kLess, b, a);
}

// The largest or the least of any number of inputs.
template <Operator operation>
Expected<ValueId> lower_extreme(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(ValueId value, lowering.input(node, 0));
  for (std::size_t i = 1; i < node.inputs.size(); ++i) {
    ROOMWISE_TRY(const ValueId other, lowering.input(node, i));
    ROOMWISE_TRY(value, lowering.arithmetic(operation, value, other));
  }
  return value;
}

Expected<ValueId> lower_negative(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId input, lowering.input(node, 0));
  Constant minus;
  minus.is_integer = lowering.is_integer(input);
  if (minus.is_integer) minus.integers = {-1};
  if (!minus.is_integer) minus.floats = {-1};
  return lowering.arithmetic(Operator::kMultiply, input, lowering.add_constant(std::move(minus)));
}

Expected<ValueId> lower_power(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId input, lowering.input(node, 0));
  ROOMWISE_TRY(const ConstantPointer exponent, lowering.constant_input(node, 1));
  if (exponent->size() != 1) return fail("expected a single number as exponent");
  const float power = exponent->is_integer ? static_cast<float>(exponent->integers.front())
                                           : exponent->floats.front();
  if (power == 2) return lowering.arithmetic(Operator::kMultiply, input, input);
  const Shape shape = lowering.shape(input);
  return lowering.add(Activation{Function::kPower, power, 0}, {input}, shape);
}

Expected<ValueId> lower_selection(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId condition, lowering.input(node, 0));
  ROOMWISE_TRY(const ValueId a, lowering.input(node, 1));
  ROOMWISE_TRY(const ValueId b, lowering.input(node, 2));
  return lowering.select(condition, a, b);
}

}  // namespace

const OperatorTable& layer_operators() {
  static const OperatorTable table = {
      {"Conv", lower_convolution},
      {"MaxPool", lower_pooling},
      {"AveragePool", lower_pooling},
      {"GlobalAveragePool", lower_reduction},
      {"ReduceMean", lower_reduction},
      {"ReduceSum", lower_reduction},
      {"ReduceL2", lower_reduction},
      {"ArgMax", lower_largest_index},
      {"LayerNormalization", lower_layer_normalization},
      {"BatchNormalization", lower_batch_normalization},
      {"Relu", lower_activation},
      {"LeakyRelu", lower_activation},
      {"Clip", lower_activation},
      {"Sigmoid", lower_activation},
      {"HardSigmoid", lower_activation},
      {"HardSwish", lower_activation},
      {"Tanh", lower_activation},
      {"Exp", lower_activation},
      {"Sqrt", lower_activation},
      {"Erf", lower_activation},
      {"Pow", lower_power},
      {"Neg", lower_negative},
      {"Add", lower_arithmetic<Operator::kAdd>},
      {"Sub", lower_arithmetic<Operator::kSubtract>},
      {"Mul", lower_arithmetic<Operator::kMultiply>},
      {"Div", lower_arithmetic<Operator::kDivide>},
      {"Max", lower_extreme<Operator::kMaximum>},
      {"Min", lower_extreme<Operator::kMinimum>},
      {"Equal", lower_arithmetic<Operator::kEqual>},
      {"Less", lower_arithmetic<Operator::kLess>},
      {"Greater", lower_greater},
      {"And", lower_arithmetic<Operator::kMultiply>},  // of truth values
      {"Or", lower_arithmetic<Operator::kMaximum>},
      {"Where", lower_selection},
  };
  return table;
}

}  // namespace roomwise::network
