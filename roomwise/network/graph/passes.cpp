#include "roomwise/network/graph/passes.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace roomwise::network {
namespace {

using Function = Activation::Function;
using Operator = Arithmetic::Operator;

// Which layer gives each value, and by how many it is used. To be made anew when layers change.
struct DefUse {
  explicit DefUse(const Program& program)
      : producer(program.values.size(), kNone), uses(count_uses(program)) {
    for (std::size_t i = 0; i < program.layers.size(); ++i) producer[program.layers[i].output] = i;
  }
  // The layer that gives `value` and whose only use is the one that is looked at; null if none.
  template <typename Operation>
  [[nodiscard]] Layer* single_use_producer(Program& program, ValueId value) const {
    if (producer[value] == kNone || uses[value] != 1) return nullptr;
    Layer& layer = program.layers[producer[value]];
    return layer.as<Operation>() != nullptr ? &layer : nullptr;
  }

  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  std::vector<std::size_t> producer;
  std::vector<std::size_t> uses;
};

// Layer `i` takes over what layer `merged` did: it stays at its own place and gives the same value.
void take_over(Program& program, std::size_t i, Layer merged) {
  merged.output = program.layers[i].output;
  program.layers[i] = std::move(merged);
}

// The number of zeros before and after all of the input along height or width.
struct ZeroPads {
  std::size_t axis = 0;
  std::int64_t before = 0;
  std::int64_t after = 0;
};
std::optional<ZeroPads> zero_pads_of(const Program& program, const Layer& layer) {
  const AxisSlices* gather = layer.as<AxisSlices>();
  if (gather == nullptr || layer.inputs.size() != 1 || gather->fill != 0 ||
      (gather->axis != 2 && gather->axis != 3) || program.values[layer.output].shape.size() != 4) {
    return std::nullopt;
  }
  const auto is_fill = [](const AxisSlices::Pick& pick) { return pick.input == AxisSlices::kFill; };
  const auto& slices = gather->slices;
  const auto first = std::ranges::find_if_not(slices, is_fill);
  const auto size = static_cast<std::size_t>(program.values[layer.inputs[0]].shape[gather->axis]);
  const auto before = static_cast<std::size_t>(first - slices.begin());
  if (slices.size() < before + size) return std::nullopt;
  for (std::size_t i = 0; i < slices.size(); ++i) {
    const bool inside = i >= before && i < before + size;
    if (inside ? slices[i] != AxisSlices::Pick{0, i - before} : !is_fill(slices[i]))
      return std::nullopt;
  }
  return ZeroPads{gather->axis - 2, static_cast<std::int64_t>(before),
                  static_cast<std::int64_t>(slices.size() - before - size)};
}

// A constant with one number a channel (or one for all) of a value of `shape`.
std::optional<std::vector<float>> per_channel(const Value& value, const Shape& shape) {
  if (value.constant == nullptr || shape.size() != 4) return std::nullopt;
  const auto channels = static_cast<std::size_t>(shape[1]);
  const std::vector<float>& numbers = value.constant->floats;
  if (numbers.size() == 1) return std::vector<float>(channels, numbers.front());
  const bool fits = value.shape.size() == 4 && value.shape[1] == shape[1];
  return fits && numbers.size() == channels ? std::optional(numbers) : std::nullopt;
}

struct Scale {
  ValueId scaled = 0;
  std::vector<float> factors;
  std::vector<float> shifts;
};

// What a layer does, if that is a factor and a shift a channel.
std::optional<Scale> scale_of(const Program& program, const Layer& layer) {
  const Arithmetic* arithmetic = layer.as<Arithmetic>();
  if (arithmetic == nullptr) return std::nullopt;
  const Operator operation = arithmetic->operation;
  constexpr std::array kScales{Operator::kAdd, Operator::kSubtract, Operator::kMultiply,
                               Operator::kDivide};
  if (std::ranges::find(kScales, operation) == kScales.end()) return std::nullopt;
  ValueId scaled = layer.inputs[0], constant = layer.inputs[1];
  if (arithmetic->commutes() && program.values[constant].constant == nullptr)
    std::swap(scaled, constant);
  const Shape& shape = program.values[layer.output].shape;
  if (program.values[scaled].shape != shape) return std::nullopt;
  auto numbers = per_channel(program.values[constant], shape);
  if (!numbers) return std::nullopt;
  Scale scale{scaled, std::vector<float>(numbers->size(), 1),
              std::vector<float>(numbers->size(), 0)};
  for (std::size_t i = 0; i < numbers->size(); ++i) {
    const float number = (*numbers)[i];
    if (operation == Operator::kAdd) scale.shifts[i] = number;
    if (operation == Operator::kSubtract) scale.shifts[i] = -number;
    if (operation == Operator::kMultiply) scale.factors[i] = number;
    if (operation == Operator::kDivide) scale.factors[i] = 1 / number;
  }
  return scale;
}

void apply_scale(Convolution& convolution, const Scale& scale) {
  auto weights = std::make_shared<Constant>(*convolution.weights);
  const std::size_t outputs = scale.factors.size();
  const std::size_t per_output = weights->floats.size() / outputs;
  convolution.bias.resize(outputs, 0);
  for (std::size_t i = 0; i < outputs; ++i) {
    for (std::size_t j = 0; j < per_output; ++j)
      weights->floats[i * per_output + j] *= scale.factors[i];
    convolution.bias[i] = convolution.bias[i] * scale.factors[i] + scale.shifts[i];
  }
  convolution.weights = std::move(weights);
}

// x * sigmoid(x), or x * clip(x / 6 + 1/2, 0, 1), as one function of x.
std::optional<Layer> match_swish(Program& program, const DefUse& def_use, const Layer& layer) {
  const Arithmetic* product = layer.as<Arithmetic>();
  if (product == nullptr || product->operation != Arithmetic::Operator::kMultiply)
    return std::nullopt;
  for (const std::size_t side : {0U, 1U}) {
    const ValueId x = layer.inputs[1 - side];
    const Layer* gate = def_use.single_use_producer<Activation>(program, layer.inputs[side]);
    if (gate == nullptr) continue;
    const Activation& function = *gate->as<Activation>();
    if (function.function == Function::kSigmoid && gate->inputs[0] == x)
      return Layer{Activation{Function::kSwish, 0, 0}, {x}, layer.output, layer.node};
    if (function.function != Function::kClip || function.alpha != 0 || function.beta != 1) continue;
    const Layer* line = def_use.single_use_producer<Activation>(program, gate->inputs[0]);
    if (line == nullptr || line->inputs[0] != x) continue;
    const Activation& linear = *line->as<Activation>();
    if (linear.function == Function::kLinear && std::abs(linear.alpha - 1.0F / 6) < 1e-6F &&
        linear.beta == 0.5F) {
      return Layer{Activation{Function::kHardSwish, 0, 0}, {x}, layer.output, layer.node};
    }
  }
  return std::nullopt;
}

}  // namespace

void fold_padding(Program& program) {
  for (Layer& layer : program.layers) {
    Convolution* convolution = layer.as<Convolution>();
    if (convolution == nullptr) continue;
    // Height's and width's pads come one after the other.
    for (bool folded = true; folded;) {
      folded = false;
      const auto padding = std::ranges::find(program.layers, layer.inputs[0], &Layer::output);
      if (padding == program.layers.end()) break;
      if (const auto pads = zero_pads_of(program, *padding)) {
        convolution->window.pads_begin[pads->axis] += pads->before;
        convolution->window.pads_end[pads->axis] += pads->after;
        layer.inputs[0] = padding->inputs[0];
        folded = true;
      }
    }
  }
  remove_unused(program);
}

void fold_scales(Program& program) {
  for (std::size_t i = 0; i < program.layers.size(); ++i) {
    const DefUse def_use(program);
    const auto scale = scale_of(program, program.layers[i]);
    if (!scale) continue;
    Layer* layer = def_use.single_use_producer<Convolution>(program, scale->scaled);
    if (layer == nullptr || layer->as<Convolution>()->adds_residual ||
        !layer->as<Convolution>()->activations.empty()) {
      continue;
    }
    Layer merged = *layer;
    apply_scale(*merged.as<Convolution>(), *scale);
    take_over(program, i, std::move(merged));
    remove_unused(program);
    --i;
  }
}

void fuse_activations(Program& program) {
  for (std::size_t i = 0; i < program.layers.size(); ++i) {
    const DefUse def_use(program);
    if (auto gated = match_swish(program, def_use, program.layers[i]))
      program.layers[i] = std::move(*gated);
  }
  remove_unused(program);
  for (std::size_t i = 0; i < program.layers.size(); ++i) {
    const Activation* activation = program.layers[i].as<Activation>();
    // oneDNN has none of the error function alone.
    if (activation == nullptr || activation->function == Function::kErf) continue;
    const DefUse def_use(program);
    Layer* layer = def_use.single_use_producer<Convolution>(program, program.layers[i].inputs[0]);
    if (layer == nullptr) continue;
    Layer merged = *layer;
    merged.as<Convolution>()->activations.push_back(*activation);
    take_over(program, i, std::move(merged));
    remove_unused(program);
    --i;
  }
}

void fuse_residuals(Program& program) {
  for (std::size_t i = 0; i < program.layers.size(); ++i) {
    const Layer& sum = program.layers[i];
    const Arithmetic* arithmetic = sum.as<Arithmetic>();
    if (arithmetic == nullptr || arithmetic->operation != Arithmetic::Operator::kAdd ||
        sum.inputs[0] == sum.inputs[1]) {
      continue;
    }
    const DefUse def_use(program);
    // The later of two convolutions takes the sum, so that the other may run before it.
    Layer* last = nullptr;
    ValueId residual = 0;
    for (const std::size_t side : {0U, 1U}) {
      Layer* layer = def_use.single_use_producer<Convolution>(program, sum.inputs[side]);
      if (layer == nullptr || layer->as<Convolution>()->adds_residual ||
          !layer->as<Convolution>()->activations.empty() || (last != nullptr && layer < last)) {
        continue;
      }
      last = layer;
      residual = sum.inputs[1 - side];
    }
    const Shape& shape = program.values[sum.output].shape;
    if (last == nullptr || program.values[residual].shape != shape ||
        program.values[last->output].shape != shape) {
      continue;
    }
    Layer merged = *last;
    merged.as<Convolution>()->adds_residual = true;
    merged.inputs.push_back(residual);
    take_over(program, i, std::move(merged));
    remove_unused(program);
    --i;
  }
}

// A mean that keeps the size and a 1x1 convolution are both linear, so either may come first; the
// mean costs less on the convolution's outputs, where those are fewer. What is not linear (the
// bias, where the padding's zeros count, and the activations) stays behind both.
void move_means_behind_pointwise(Program& program) {
  for (std::size_t i = 0; i < program.layers.size(); ++i) {
    const Convolution* convolution = program.layers[i].as<Convolution>();
    if (convolution == nullptr || !convolution->is_pointwise()) continue;
    const Layer given = program.layers[i];
    const DefUse def_use(program);
    Layer* mean = def_use.single_use_producer<Pooling>(program, given.inputs[0]);
    const Shape wanted = program.values[given.output].shape;
    if (mean == nullptr || mean->as<Pooling>()->kind == Pooling::Kind::kMaximum) continue;
    const Shape& before = program.values[mean->inputs[0]].shape;
    if (before[2] != wanted[2] || before[3] != wanted[3] || wanted[1] >= before[1]) continue;

    Layer swapped = *mean;
    std::vector<Layer> behind;
    ValueId last = 0;
    const auto add = [&](auto operation, std::vector<ValueId> inputs) {
      program.values.push_back({wanted, nullptr});
      last = program.values.size() - 1;
      behind.push_back({std::move(operation), std::move(inputs), last, given.node});
    };
    Convolution linear = *convolution;
    linear.activations.clear();
    Constant bias;
    if (swapped.as<Pooling>()->kind == Pooling::Kind::kMeanIncludingPadding) {
      bias.floats = std::exchange(linear.bias, {});
      bias.shape = {1, wanted[1], 1, 1};
    }
    program.values.push_back({wanted, nullptr});
    const ValueId sums = program.values.size() - 1;
    *mean = {std::move(linear), {swapped.inputs[0]}, sums, given.node};
    add(*swapped.as<Pooling>(), {sums});
    if (!bias.floats.empty()) {
      program.values.push_back({bias.shape, std::make_shared<const Constant>(bias)});
      add(Arithmetic{Arithmetic::Operator::kAdd}, {last, program.values.size() - 1});
    }
    for (const Activation& activation : given.as<Convolution>()->activations)
      add(activation, {last});
    behind.back().output = given.output;
    const auto place =
        program.layers.erase(program.layers.begin() + static_cast<std::ptrdiff_t>(i));
    program.layers.insert(place, behind.begin(), behind.end());
  }
}

void remove_unused(Program& program) {
  std::vector<std::size_t> uses = count_uses(program);
  std::vector<Layer> kept;
  for (auto layer = program.layers.rbegin(); layer != program.layers.rend(); ++layer) {
    if (uses[layer->output] == 0) {
      for (const ValueId input : layer->inputs) --uses[input];
    } else {
      kept.push_back(std::move(*layer));
    }
  }
  std::ranges::reverse(kept);
  program.layers = std::move(kept);
}

Program run_passes(Program program, const PassOptions& options) {
  remove_unused(program);
  if (options.folds_padding) fold_padding(program);
  if (options.folds_scales) fold_scales(program);
  if (options.combines_gathers) combine_gathers(program);
  // Sums first: an activation behind one then follows it into the convolution.
  if (options.fuses_residuals) fuse_residuals(program);
  if (options.fuses_activations) fuse_activations(program);
  if (options.swaps_means) move_means_behind_pointwise(program);
  return program;
}

}  // namespace roomwise::network
