#include "roomwise/network/executor/quantization.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "roomwise/base/disjoint_sets.h"
#include "roomwise/network/executor/executor.h"
#include "roomwise/network/executor/plan.h"

namespace roomwise::network {
namespace {

constexpr std::int64_t kMaxColors = 3;
constexpr const char* kInputName = "";

// By value: whether a convolution in 8 bits looks at it, or what is handed on to one.
std::vector<bool> values_for_convolutions(const Program& program, std::int64_t min_channels) {
  std::vector<bool> wanted(program.values.size(), false);
  for (auto layer = program.layers.rbegin(); layer != program.layers.rend(); ++layer) {
    const ValueId first = layer->inputs.front();
    if (layer->as<Convolution>() != nullptr &&
        program.values[first].shape[1] >= std::max(min_channels, kMaxColors + 1)) {
      wanted[first] = true;
    } else if (wanted[layer->output] && preserves_quantization(program, *layer)) {
      for (const ValueId input : layer->inputs)
        wanted[input] = wanted[input] || program.values[input].shape[1] >= min_channels;
    }
  }
  for (std::size_t i = 0; i < wanted.size(); ++i)
    wanted[i] = wanted[i] && program.values[i].constant == nullptr;
  return wanted;
}

EightBits eight_bits_for(const ActivationRange& range) {
  const bool is_signed = range.least < 0;
  const float largest = std::max(std::abs(range.least), std::abs(range.most));
  const float step = largest / (is_signed ? 127.0F : 255.0F);
  return {step > 0 ? step : 1, is_signed};
}

}  // namespace

bool preserves_quantization(const Program& program, const Layer& layer) {
  if (program.values[layer.output].shape.size() != 4) return false;
  if (const Pooling* pooling = layer.as<Pooling>()) {
    // The mean of a whole picture is a feature, and not to be rounded.
    const Shape& shape = program.values[layer.output].shape;
    return pooling->kind == Pooling::Kind::kMaximum || shape[2] * shape[3] > 1;
  }
  const AxisSlices* gather = layer.as<AxisSlices>();
  return gather != nullptr && gather->axis == 1 && concatenates_whole_inputs(program, layer);
}

std::vector<std::string> names_of_layers(const Program& program) {
  std::vector<std::string> names;
  std::set<std::string> taken{kInputName};
  for (const Layer& layer : program.layers) {
    std::string name = layer.node;
    for (int number = 2; !taken.insert(name).second; ++number)
      name = fmt::format("{} #{}", layer.node, number);
    names.push_back(std::move(name));
  }
  return names;
}

std::map<std::string, ActivationRange> named_ranges(const Program& program,
                                                    std::span<const ActivationRange> ranges) {
  std::map<std::string, ActivationRange> named{{kInputName, ranges[program.inputs.front()]}};
  const std::vector<std::string> names = names_of_layers(program);
  for (std::size_t i = 0; i < names.size(); ++i) named[names[i]] = ranges[program.layers[i].output];
  return named;
}

Expected<std::vector<ActivationRange>> ranges_of_values(const Program& program,
                                                        const EightBitRanges& ranges) {
  if (program.inputs.size() != 1) return fail("8 bits need a network of one input");
  const Shape& shape = program.values[program.inputs.front()].shape;
  if (shape != ranges.input) {
    return fail("8 bits were measured on inputs of {}, not {}", shape_text(ranges.input),
                shape_text(shape));
  }
  std::vector<ActivationRange> of_values(program.values.size());
  const auto take = [&](const std::string& name, ValueId value) -> Expected<void> {
    const auto found = ranges.of_layers.find(name);
    if (found == ranges.of_layers.end()) {
      return fail("for 8 bits nothing was measured of the layer \"{}\"; measure the network anew",
                  name);
    }
    of_values[value] = found->second;
    return {};
  };
  ROOMWISE_RETURN_IF_ERROR(take(kInputName, program.inputs.front()));
  const std::vector<std::string> names = names_of_layers(program);
  for (std::size_t i = 0; i < names.size(); ++i)
    ROOMWISE_RETURN_IF_ERROR(take(names[i], program.layers[i].output));
  return of_values;
}

Expected<std::vector<ActivationRange>> calibrate_ranges(const Program& program,
                                                        std::span<const Tensor> inputs) {
  if (inputs.empty() || program.inputs.size() != 1) {
    return fail("a network of one input, and some inputs to look at, are needed for 8 bits");
  }
  Program watched = program;
  watched.outputs.clear();
  for (const Layer& layer : program.layers) watched.outputs.push_back(layer.output);
  watched.outputs.push_back(program.inputs.front());
  ROOMWISE_TRY(auto plan, make_plan(watched, {}));
  PlanRun run(std::move(plan));
  std::vector<ActivationRange> ranges(program.values.size()), extremes(program.values.size());
  const auto share = 1 / static_cast<float>(inputs.size());
  for (const Tensor& input : inputs) {
    if (input.shape != program.values[program.inputs.front()].shape) {
      return fail("8 bits were measured on inputs of {}, not {}", shape_text(input.shape),
                  shape_text(program.values[program.inputs.front()].shape));
    }
    const std::span<const float> values = input.values;
    ROOMWISE_TRY(const auto outputs, run.run({&values, 1}));
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      ActivationRange& range = ranges[watched.outputs[i]];
      const auto [least, most] = std::ranges::minmax(outputs[i]);
      range.least += share * least;
      range.most += share * most;
      ActivationRange& extreme = extremes[watched.outputs[i]];
      extreme = {std::min(extreme.least, least), std::max(extreme.most, most)};
    }
  }
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    ranges[i].least = std::midpoint(ranges[i].least, extremes[i].least);
    ranges[i].most = std::midpoint(ranges[i].most, extremes[i].most);
  }
  return ranges;
}

void quantize(Program& program, std::span<const ActivationRange> ranges,
              std::int64_t min_channels) {
  const std::vector<bool> wanted = values_for_convolutions(program, min_channels);
  DisjointSets together(program.values.size());
  for (const Layer& layer : program.layers) {
    if (!wanted[layer.output] || !preserves_quantization(program, layer)) continue;
    for (const ValueId input : layer.inputs) {
      if (wanted[input]) together.join(input, layer.output);
    }
  }
  std::vector<ActivationRange> of_set(program.values.size(), {0, 0});
  for (ValueId value = 0; value < wanted.size(); ++value) {
    if (!wanted[value]) continue;
    ActivationRange& range = of_set[together.find(value)];
    range = {std::min(range.least, ranges[value].least), std::max(range.most, ranges[value].most)};
  }
  for (ValueId value = 0; value < wanted.size(); ++value) {
    if (wanted[value])
      program.values[value].eight_bits = eight_bits_for(of_set[together.find(value)]);
  }
}

}  // namespace roomwise::network
