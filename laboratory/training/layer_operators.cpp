// Convolutions, pooling, batch normalisation, products, element-wise functions.
#include <ATen/Functions.h>
#include <ATen/TensorOperators.h>

#include <algorithm>
#include <array>
#include <limits>

#include "laboratory/training/operators.h"

namespace roomwise::training {
namespace {

using Pair = std::array<std::int64_t, 2>;

// How a window moves over a picture, as the node says it.
struct Window {
  std::vector<std::int64_t> strides, dilations, pads;  // pads: top, left, bottom, right
  std::string automatic;

  static Expected<Window> of(const network::Node& node) {
    Window window{node.integers("strides", {1, 1}), node.integers("dilations", {1, 1}),
                  node.integers("pads", {0, 0, 0, 0}), node.text("auto_pad", "NOTSET")};
    if (window.strides.size() != 2 || window.dilations.size() != 2 || window.pads.size() != 4) {
      return fail("works on other than pictures; two strides and four pads are understood");
    }
    if (window.automatic == "VALID") window.pads = {0, 0, 0, 0};
    return window;
  }

  // The pads for an input of these sizes.
  [[nodiscard]] std::vector<std::int64_t> pads_for(const at::Tensor& input, Pair kernel) const {
    if (!automatic.starts_with("SAME")) return pads;
    std::vector<std::int64_t> found(4);
    for (std::size_t i = 0; i < 2; ++i) {
      const std::int64_t size = input.size(static_cast<std::int64_t>(2 + i));
      const std::int64_t outputs = (size + strides[i] - 1) / strides[i];
      const std::int64_t reach = (kernel[i] - 1) * dilations[i] + 1;
      const std::int64_t missing =
          std::max<std::int64_t>(0, (outputs - 1) * strides[i] + reach - size);
      const std::int64_t less = missing / 2;
      found[i] = automatic == "SAME_LOWER" ? missing - less : less;
      found[2 + i] = missing - found[i];
    }
    return found;
  }
};

bool is_symmetric(const std::vector<std::int64_t>& pads) {
  return pads[0] == pads[2] && pads[1] == pads[3];
}

at::Tensor padded(const at::Tensor& input, const std::vector<std::int64_t>& pads, double value) {
  return at::constant_pad_nd(input, {pads[1], pads[3], pads[0], pads[2]}, value);
}

Expected<Operation> make_convolution(const network::Node& node, std::int64_t) {
  ROOMWISE_TRY(const Window window, Window::of(node));
  const std::int64_t groups = node.integer("group", 1);
  return [window, groups](const Values& in, bool) -> Values {
    TORCH_CHECK(in.size() >= 2 && in[1].dim() == 4, "expected weights of four sizes");
    at::Tensor input = in[0];
    std::vector<std::int64_t> pads = window.pads_for(input, {in[1].size(2), in[1].size(3)});
    if (!is_symmetric(pads)) {
      input = padded(input, pads, 0);
      pads = {0, 0, 0, 0};
    }
    const at::Tensor bias = in.size() > 2 ? in[2] : at::Tensor();
    return {at::conv2d(input, in[1], bias, window.strides, {pads[0], pads[1]}, window.dilations,
                       groups)};
  };
}

// The mean of windows that count only what lies inside the picture, with any pads.
at::Tensor mean_inside(const at::Tensor& input, const std::vector<std::int64_t>& kernel,
                       const Window& window, const std::vector<std::int64_t>& pads) {
  const auto mean = [&](const at::Tensor& values) {
    return at::avg_pool2d(padded(values, pads, 0), kernel, window.strides);
  };
  const at::Tensor ones = at::ones({1, 1, input.size(2), input.size(3)}, input.options());
  return mean(input) / mean(ones);
}

Expected<Operation> make_pooling(const network::Node& node, std::int64_t) {
  ROOMWISE_TRY(const Window window, Window::of(node));
  const auto kernel = node.integers("kernel_shape", {});
  if (kernel.size() != 2) return fail("expected a kernel_shape of two numbers");
  const bool ceil = node.integer("ceil_mode", 0) != 0;
  const bool counts_pads = node.integer("count_include_pad", 0) != 0;
  const bool is_mean = node.operation == "AveragePool";
  if (window.dilations != std::vector<std::int64_t>{1, 1})
    return fail("its dilations are not supported; 1 is");
  if (node.outputs.size() > 1 && !node.outputs[1].empty())
    return fail("the indices of a maximum are not supported");
  return [=](const Values& in, bool) -> Values {
    const at::Tensor& input = in[0];
    const auto pads = window.pads_for(input, {kernel[0], kernel[1]});
    const bool plain = is_symmetric(pads) && 2 * pads[0] <= kernel[0] && 2 * pads[1] <= kernel[1];
    TORCH_CHECK(plain || !ceil, "ceil_mode with pads of two kinds is not supported");
    if (!is_mean) {
      constexpr double kLowest = -std::numeric_limits<double>::infinity();
      if (!plain) return {at::max_pool2d(padded(input, pads, kLowest), kernel, window.strides)};
      return {at::max_pool2d(input, kernel, window.strides, {pads[0], pads[1]}, {1, 1}, ceil)};
    }
    if (!plain && !counts_pads) return {mean_inside(input, kernel, window, pads)};
    if (!plain) return {at::avg_pool2d(padded(input, pads, 0), kernel, window.strides)};
    return {at::avg_pool2d(input, kernel, window.strides, {pads[0], pads[1]}, ceil, counts_pads)};
  };
}

Expected<Operation> make_mean(const network::Node& node, std::int64_t) {
  const bool global = node.operation == "GlobalAveragePool";
  const bool keeps = global || node.integer("keepdims", 1) != 0;
  const auto named = node.integers("axes", {});
  return [=](const Values& in, bool) -> Values {
    std::vector<std::int64_t> axes = named;
    for (std::int64_t axis = global ? 2 : 0; named.empty() && axis < in[0].dim(); ++axis)
      axes.push_back(axis);
    return {at::mean(in[0], axes, keeps)};
  };
}

// Running values are kept as ONNX's momentum says: of the old ones that share remains.
Expected<Operation> make_batch_normalization(const network::Node& node, std::int64_t) {
  const double epsilon = static_cast<double>(node.number("epsilon", 1e-5F));
  const double remaining = static_cast<double>(node.number("momentum", 0.9F));
  return [=](const Values& in, bool learning) -> Values {
    TORCH_CHECK(in.size() == 5, "expected five inputs");
    return {at::batch_norm(in[0], in[1], in[2], in[3], in[4], learning, 1 - remaining, epsilon,
                           /*cudnn_enabled=*/true)};
  };
}

Expected<Operation> make_gemm(const network::Node& node, std::int64_t) {
  const bool turns_a = node.integer("transA", 0) != 0, turns_b = node.integer("transB", 0) != 0;
  const auto alpha = static_cast<double>(node.number("alpha", 1));
  const auto beta = static_cast<double>(node.number("beta", 1));
  return [=](const Values& in, bool) -> Values {
    TORCH_CHECK(in.size() >= 2, "expected two inputs");
    const at::Tensor a = turns_a ? in[0].t() : in[0];
    const at::Tensor b = turns_b ? in[1].t() : in[1];
    if (in.size() > 2 && in[2].defined()) return {at::addmm(in[2], a, b, beta, alpha)};
    return {alpha == 1 ? at::mm(a, b) : at::mm(a, b) * alpha};
  };
}

Expected<Operation> make_matmul(const network::Node&, std::int64_t) {
  return [](const Values& in, bool) -> Values {
    TORCH_CHECK(in.size() == 2, "expected two inputs");
    return {at::matmul(in[0], in[1])};
  };
}

Expected<Operation> make_softmax(const network::Node& node, std::int64_t opset) {
  const bool flattens = opset < 13;  // everything from the axis on was one axis
  const std::int64_t axis = node.integer("axis", flattens ? 1 : -1);
  return [=](const Values& in, bool) -> Values {
    if (!flattens) return {at::softmax(in[0], axis)};
    const std::int64_t first = axis < 0 ? axis + in[0].dim() : axis;
    return {at::softmax(in[0].flatten(first), first).reshape(in[0].sizes())};
  };
}

// One limit of a Clip: an attribute before opset 11, an input since.
Expected<Operation> make_clip(const network::Node& node, std::int64_t opset) {
  constexpr float kLargest = std::numeric_limits<float>::max();
  const float low = node.number("min", -kLargest), high = node.number("max", kLargest);
  return [=](const Values& in, bool) -> Values {
    const auto limit = [&](std::size_t i, float attribute, float none) -> double {
      if (opset < 11) return static_cast<double>(attribute);
      const bool given = i < in.size() && in[i].defined();
      return given ? in[i].item<double>() : static_cast<double>(none);
    };
    // Gives what clamp() gives, with gradients that cost a tenth.
    return {at::hardtanh(in[0], limit(1, low, -kLargest), limit(2, high, kLargest))};
  };
}

template <at::Tensor (*function)(const at::Tensor&)>
Expected<Operation> make_function(const network::Node&, std::int64_t) {
  return [](const Values& in, bool) -> Values { return {function(in[0])}; };
}

Expected<Operation> make_leaky_relu(const network::Node& node, std::int64_t) {
  const auto slope = static_cast<double>(node.number("alpha", 0.01F));
  return [=](const Values& in, bool) -> Values { return {at::leaky_relu(in[0], slope)}; };
}

Expected<Operation> make_hard_sigmoid(const network::Node& node, std::int64_t) {
  const auto slope = static_cast<double>(node.number("alpha", 0.2F));
  const auto shift = static_cast<double>(node.number("beta", 0.5F));
  return [=](const Values& in, bool) -> Values { return {at::clamp(in[0] * slope + shift, 0, 1)}; };
}

at::Tensor add(const at::Tensor& a, const at::Tensor& b) {
  return at::add(a, b);
}
at::Tensor subtract(const at::Tensor& a, const at::Tensor& b) {
  return at::sub(a, b);
}
at::Tensor multiply(const at::Tensor& a, const at::Tensor& b) {
  return at::mul(a, b);
}
// Whole numbers (of shapes) are divided to whole numbers, towards zero.
at::Tensor divide(const at::Tensor& a, const at::Tensor& b) {
  const bool whole = !a.is_floating_point() && !b.is_floating_point();
  return whole ? at::div(a, b, "trunc") : at::div(a, b);
}

template <at::Tensor (*function)(const at::Tensor&, const at::Tensor&)>
Expected<Operation> make_arithmetic(const network::Node&, std::int64_t) {
  return [](const Values& in, bool) -> Values {
    TORCH_CHECK(in.size() == 2, "expected two inputs");
    return {function(in[0], in[1])};
  };
}

}  // namespace

const OperatorTable& layer_operators() {
  static const OperatorTable table = {
      {"Conv", make_convolution},
      {"MaxPool", make_pooling},
      {"AveragePool", make_pooling},
      {"GlobalAveragePool", make_mean},
      {"ReduceMean", make_mean},
      {"BatchNormalization", make_batch_normalization},
      {"Gemm", make_gemm},
      {"MatMul", make_matmul},
      {"Softmax", make_softmax},
      {"Relu", make_function<at::relu>},
      {"Sigmoid", make_function<at::sigmoid>},
      {"Tanh", make_function<at::tanh>},
      {"Exp", make_function<at::exp>},
      {"HardSwish", make_function<at::hardswish>},
      {"LeakyRelu", make_leaky_relu},
      {"HardSigmoid", make_hard_sigmoid},
      {"Clip", make_clip},
      {"Add", make_arithmetic<add>},
      {"Sub", make_arithmetic<subtract>},
      {"Mul", make_arithmetic<multiply>},
      {"Div", make_arithmetic<divide>},
  };
  return table;
}

}  // namespace roomwise::training
