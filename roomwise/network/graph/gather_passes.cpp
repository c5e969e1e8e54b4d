// Joins, splits, slices and channel shuffles in a row become one gathering of slices.
#include <algorithm>
#include <optional>

#include "roomwise/network/graph/passes.h"

namespace roomwise::network {
namespace {

using Pick = AxisSlices::Pick;

// A 1x1 convolution each of whose outputs is a copy of one input (as some exporters write a channel
// shuffle), as the gathering that it is.
std::optional<AxisSlices> gather_of(const Convolution& convolution) {
  if (!convolution.is_pointwise() || !convolution.activations.empty() ||
      std::ranges::any_of(convolution.bias, [](float bias) { return bias != 0; })) {
    return std::nullopt;
  }
  const auto inputs = static_cast<std::size_t>(convolution.weights->shape[1]);
  const std::vector<float>& weights = convolution.weights->floats;
  AxisSlices gather;
  for (std::size_t begin = 0; begin < weights.size(); begin += inputs) {
    std::optional<std::size_t> copied;
    for (std::size_t i = 0; i < inputs; ++i) {
      if (weights[begin + i] == 0) continue;
      if (weights[begin + i] != 1 || copied) return std::nullopt;
      copied = i;
    }
    if (!copied) return std::nullopt;
    gather.slices.push_back({0, *copied});
  }
  return gather;
}

const Layer* maker_of(const Program& program, ValueId value) {
  const auto found = std::ranges::find(program.layers, value, &Layer::output);
  return found == program.layers.end() ? nullptr : &*found;
}

// The axis of 1 x a x b x ... that a view splits or joins: batch x channels x the rest becomes
// batch x groups x channels / groups x the rest.
bool splits_channels(const Shape& whole, const Shape& split) {
  return whole.size() == 4 && split.size() == 5 && split[0] == whole[0] &&
         split[1] * split[2] == whole[1] && split[3] == whole[2] && split[4] == whole[3];
}

// A view as groups, the groups' axes swapped, a view back: a channel shuffle.
std::optional<Layer> shuffle_of(const Program& program, const Layer& last) {
  if (last.as<View>() == nullptr) return std::nullopt;
  const Layer* middle = maker_of(program, last.inputs[0]);
  if (middle == nullptr || middle->as<Permutation>() == nullptr ||
      middle->as<Permutation>()->axes != std::vector<std::size_t>{0, 2, 1, 3, 4}) {
    return std::nullopt;
  }
  const Layer* first = maker_of(program, middle->inputs[0]);
  if (first == nullptr || first->as<View>() == nullptr) return std::nullopt;
  const Shape& split = program.values[first->output].shape;
  if (!splits_channels(program.values[first->inputs[0]].shape, split) ||
      program.values[last.output].shape != program.values[first->inputs[0]].shape) {
    return std::nullopt;
  }
  const auto groups = static_cast<std::size_t>(split[1]);
  const auto members = static_cast<std::size_t>(split[2]);
  AxisSlices gather;
  for (std::size_t member = 0; member < members; ++member) {
    for (std::size_t group = 0; group < groups; ++group)
      gather.slices.push_back({0, group * members + member});
  }
  return Layer{std::move(gather), {first->inputs[0]}, last.output, last.node};
}

// The gathering of a gathering, from where the slices came in the first place.
void look_through(const Program& program, Layer& layer) {
  AxisSlices& gather = *layer.as<AxisSlices>();
  for (std::size_t input = 0; input < layer.inputs.size(); ++input) {
    const Layer* inner = maker_of(program, layer.inputs[input]);
    if (inner == nullptr || inner->as<AxisSlices>() == nullptr) continue;
    const AxisSlices& from = *inner->as<AxisSlices>();
    const bool fills = std::ranges::count(from.slices, AxisSlices::kFill, &Pick::input) > 0;
    if (from.axis != gather.axis || fills) continue;
    const std::size_t offset = layer.inputs.size();
    layer.inputs.insert(layer.inputs.end(), inner->inputs.begin(), inner->inputs.end());
    for (Pick& pick : gather.slices) {
      if (pick.input != input) continue;
      pick = from.slices[pick.index];
      pick.input += offset;
    }
  }
}

// Names every input once and only where it is used.
void tidy_inputs(Layer& layer) {
  AxisSlices& gather = *layer.as<AxisSlices>();
  std::vector<ValueId> inputs;
  for (Pick& pick : gather.slices) {
    if (pick.input == AxisSlices::kFill) continue;
    const ValueId value = layer.inputs[pick.input];
    const auto found = std::ranges::find(inputs, value);
    pick.input = static_cast<std::size_t>(found - inputs.begin());
    if (found == inputs.end()) inputs.push_back(value);
  }
  layer.inputs = std::move(inputs);
}

bool is_whole_input(const Program& program, const Layer& layer) {
  return layer.as<AxisSlices>() != nullptr && layer.inputs.size() == 1 &&
         concatenates_whole_inputs(program, layer);
}

}  // namespace

bool concatenates_whole_inputs(const Program& program, const Layer& layer) {
  const AxisSlices& gather = *layer.as<AxisSlices>();
  std::vector<Pick> expected;
  for (std::size_t input = 0; input < layer.inputs.size(); ++input) {
    const auto size =
        static_cast<std::size_t>(program.values[layer.inputs[input]].shape[gather.axis]);
    for (std::size_t i = 0; i < size; ++i) expected.push_back({input, i});
  }
  return gather.slices == expected;
}

void combine_gathers(Program& program) {
  for (Layer& layer : program.layers) {
    if (const Convolution* convolution = layer.as<Convolution>()) {
      if (auto gather = gather_of(*convolution)) layer.operation = std::move(*gather);
    }
    if (auto shuffle = shuffle_of(program, layer)) layer = std::move(*shuffle);
  }
  for (std::size_t i = 0; i < program.layers.size(); ++i) {
    Layer& layer = program.layers[i];
    if (layer.as<AxisSlices>() == nullptr) continue;
    look_through(program, layer);
    tidy_inputs(layer);
    if (!is_whole_input(program, layer)) continue;
    // It changes nothing: those after it take its input. An output that it gives is the input's.
    const ValueId from = layer.output, to = layer.inputs[0];
    for (Layer& later : program.layers) std::ranges::replace(later.inputs, from, to);
    std::ranges::replace(program.outputs, from, to);
  }
  remove_unused(program);
}

}  // namespace roomwise::network
