// What moves, reshapes and slices values.
#include <algorithm>
#include <numeric>
#include <optional>

#include "roomwise/network/graph/constant_math.h"
#include "roomwise/network/graph/lowering.h"

namespace roomwise::network {
namespace {

std::vector<std::size_t> range(std::size_t begin, std::size_t end) {
  std::vector<std::size_t> indices(end - begin);
  std::iota(indices.begin(), indices.end(), begin);
  return indices;
}

// Whole numbers given by an input in newer opsets and by an attribute in older ones.
Expected<std::vector<std::int64_t>> integers_of(const Lowering& lowering, const Node& node,
                                                std::size_t i, const std::string& attribute) {
  if (lowering.has_input(node, i)) return lowering.integers_input(node, i);
  return node.integers(attribute, {});
}

Expected<ValueId> lower_gather(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId input, lowering.input(node, 0));
  ROOMWISE_TRY(const ValueId places, lowering.input(node, 1));
  if (!lowering.is_integer(places)) return fail("its indices are no whole numbers");
  const Shape shape = lowering.shape(input), of_places = lowering.shape(places);
  ROOMWISE_TRY(const std::size_t axis, axis_of(node.integer("axis", 0), shape.size()));
  const auto at = static_cast<std::ptrdiff_t>(axis);
  Shape result(shape.begin(), shape.begin() + at);
  result.insert(result.end(), of_places.begin(), of_places.end());
  result.insert(result.end(), shape.begin() + at + 1, shape.end());
  const ConstantPointer indices = lowering.constant(places);
  if (indices == nullptr) return lowering.add(Gather{axis}, {input, places}, std::move(result));
  std::vector<std::size_t> slices;
  for (const std::int64_t index : indices->integers) {
    if (index < -shape[axis] || index >= shape[axis])
      return fail("its input {} has no index {}", shape_text(shape), index);
    slices.push_back(static_cast<std::size_t>(index < 0 ? index + shape[axis] : index));
  }
  ROOMWISE_TRY(const ValueId picked, lowering.pick(input, axis, slices));
  return lowering.reshape(picked, result);
}

Expected<ValueId> lower_concat(Lowering& lowering, const Node& node) {
  std::vector<ValueId> inputs;
  std::vector<ConstantPointer> constants;
  for (std::size_t i = 0; i < node.inputs.size(); ++i) {
    ROOMWISE_TRY(const ValueId input, lowering.input(node, i));
    inputs.push_back(input);
    if (lowering.constant(input) != nullptr) constants.push_back(lowering.constant(input));
  }
  if (inputs.empty()) return fail("joins nothing");
  Shape shape = lowering.shape(inputs.front());
  ROOMWISE_TRY(const std::size_t axis, axis_of(node.integer("axis", 1), shape.size()));
  shape[axis] = 0;
  AxisSlices gather;
  gather.axis = axis;
  for (std::size_t input = 0; input < inputs.size(); ++input) {
    Shape part = lowering.shape(inputs[input]);
    if (part.size() != shape.size())
      return fail("cannot join {} to {}", shape_text(part), shape_text(shape));
    const std::int64_t size = std::exchange(part[axis], shape[axis]);
    if (part != shape) return fail("cannot join {} to {}", shape_text(part), shape_text(shape));
    shape[axis] += size;
    ROOMWISE_RETURN_IF_ERROR(check_size(shape));
    for (std::size_t i = 0; i < static_cast<std::size_t>(size); ++i)
      gather.slices.push_back({input, i});
  }
  const auto alike = [&](const ConstantPointer& constant) {
    return constant->is_integer == constants.front()->is_integer;
  };
  if (constants.size() == inputs.size() && std::ranges::all_of(constants, alike)) {
    return lowering.add_constant(join(constants, axis));
  }
  return lowering.add(std::move(gather), inputs, shape);
}

// The indices that a slice keeps of an axis of `size`.
Expected<std::vector<std::size_t>> slice(std::int64_t start, std::int64_t end, std::int64_t step,
                                         std::int64_t size) {
  if (step == 0) return fail("its step is 0");
  const auto limited = [&](std::int64_t place, std::int64_t low, std::int64_t high) {
    return std::clamp(place < 0 ? std::max(place, -size - 1) + size : place, low, high);
  };
  step = std::clamp(step, -size - 1, size + 1);
  start = step > 0 ? limited(start, 0, size) : limited(start, -1, size - 1);
  end = step > 0 ? limited(end, 0, size) : (end < -size ? -1 : limited(end, -1, size - 1));
  std::vector<std::size_t> indices;
  for (std::int64_t i = start; step > 0 ? i < end : i > end; i += step)
    indices.push_back(static_cast<std::size_t>(i));
  return indices;
}

Expected<ValueId> lower_slice(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(ValueId value, lowering.input(node, 0));
  const std::size_t rank = lowering.shape(value).size();
  ROOMWISE_TRY(const auto starts, lowering.integers_input(node, 1));
  ROOMWISE_TRY(const auto ends, lowering.integers_input(node, 2));
  std::vector<std::size_t> axes = range(0, starts.size());
  if (lowering.has_input(node, 3)) {
    ROOMWISE_TRY(const auto named, lowering.integers_input(node, 3));
    ROOMWISE_TRY(axes, axes_of(named, rank));
  }
  std::vector<std::int64_t> steps(starts.size(), 1);
  if (lowering.has_input(node, 4)) {
    ROOMWISE_TRY(steps, lowering.integers_input(node, 4));
  }
  if (ends.size() != starts.size() || axes.size() != starts.size() ||
      steps.size() != starts.size()) {
    return fail("its starts, ends, axes and steps are not of one number");
  }
  if (starts.size() > rank) return fail("slices {} axes of {}", starts.size(), rank);
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const std::int64_t size = lowering.shape(value)[axes[i]];
    ROOMWISE_TRY(const auto kept, slice(starts[i], ends[i], steps[i], size));
    if (kept.size() == static_cast<std::size_t>(size) && steps[i] > 0) continue;
    ROOMWISE_TRY(value, lowering.pick(value, axes[i], kept));
  }
  return value;
}

Expected<ValueId> lower_split(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId input, lowering.input(node, 0));
  const Shape shape = lowering.shape(input);
  ROOMWISE_TRY(const std::size_t axis, axis_of(node.integer("axis", 0), shape.size()));
  ROOMWISE_TRY(auto sizes, integers_of(lowering, node, 1, "split"));
  const auto parts = static_cast<std::int64_t>(node.outputs.size());
  if (sizes.empty() && parts > 0 && shape[axis] % parts == 0)
    sizes.assign(node.outputs.size(), shape[axis] / parts);
  std::int64_t begin = 0;
  ValueId first = input;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    if (sizes[i] < 0 || sizes[i] > shape[axis] - begin) break;
    const auto part =
        range(static_cast<std::size_t>(begin), static_cast<std::size_t>(begin + sizes[i]));
    ROOMWISE_TRY(const ValueId output, lowering.pick(input, axis, part));
    if (i == 0) first = output;
    lowering.set_output(node, i, output);
    begin += sizes[i];
  }
  if (begin != shape[axis] || sizes.size() != node.outputs.size())
    return fail("its parts do not make up its input {}", shape_text(shape));
  return first;
}

Expected<ValueId> lower_pad(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(ValueId value, lowering.input(node, 0));
  if (const std::string mode = node.text("mode", "constant"); mode != "constant")
    return fail("its mode \"{}\" is not supported; \"constant\" is", mode);
  ROOMWISE_TRY(const auto pads, integers_of(lowering, node, 1, "pads"));
  float fill = node.number("value", 0);
  if (lowering.has_input(node, 2)) {
    ROOMWISE_TRY(const std::vector<float> values, lowering.floats_input(node, 2));
    if (!values.empty()) fill = values.front();
  }
  const std::size_t rank = lowering.shape(value).size();
  if (pads.size() != 2 * rank) return fail("has {} pads for {} axes", pads.size(), rank);
  for (std::size_t axis = 0; axis < rank; ++axis) {
    const std::int64_t before = pads[axis], after = pads[axis + rank];
    Shape shape = lowering.shape(value);
    constexpr std::int64_t kMax = 1 << 20;
    if (before > kMax || after > kMax || before < -shape[axis] || after < -shape[axis])
      return fail("its pads {} and {} do not fit {}", before, after, shape_text(shape));
    if (before == 0 && after == 0) continue;
    AxisSlices gather;
    gather.axis = axis;
    gather.fill = fill;
    for (std::int64_t i = -before; i < shape[axis] + after; ++i) {
      const bool inside = i >= 0 && i < shape[axis];
      gather.slices.push_back(inside ? AxisSlices::Pick{0, static_cast<std::size_t>(i)}
                                     : AxisSlices::Pick{AxisSlices::kFill, 0});
    }
    shape[axis] = static_cast<std::int64_t>(gather.slices.size());
    ROOMWISE_TRY(value, lowering.add(std::move(gather), {value}, std::move(shape)));
  }
  return value;
}

Expected<ValueId> lower_reshape(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId input, lowering.input(node, 0));
  ROOMWISE_TRY(Shape wanted, lowering.integers_input(node, 1));
  const Shape shape = lowering.shape(input);
  std::optional<std::size_t> open;
  Shape known = wanted;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (wanted[i] == 0 && node.integer("allowzero", 0) == 0) {
      if (i >= shape.size()) return fail("keeps an axis that {} lacks", shape_text(shape));
      wanted[i] = known[i] = shape[i];
    }
    if (wanted[i] != -1) continue;
    if (open) return fail("leaves two sizes open");
    open = i;
    known[i] = 1;
  }
  ROOMWISE_RETURN_IF_ERROR(check_size(known));
  if (open) {
    const std::size_t rest = element_count(known);
    if (rest == 0) return fail("cannot bring {} into an empty shape", shape_text(shape));
    wanted[*open] = static_cast<std::int64_t>(element_count(shape) / rest);
  }
  return lowering.reshape(input, wanted);
}

Expected<ValueId> lower_expand(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId input, lowering.input(node, 0));
  ROOMWISE_TRY(const Shape wanted, lowering.integers_input(node, 1));
  return lowering.expand(input, wanted);
}

Expected<ValueId> lower_flatten(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId input, lowering.input(node, 0));
  const Shape shape = lowering.shape(input);
  const auto rank = static_cast<std::int64_t>(shape.size());
  std::int64_t axis = node.integer("axis", 1);
  if (axis < 0) axis += rank;
  if (axis < 0 || axis > rank) return fail("has no axis {} among {}", axis, rank);
  Shape flat{1, 1};
  for (std::size_t i = 0; i < shape.size(); ++i)
    flat[static_cast<std::int64_t>(i) < axis ? 0 : 1] *= shape[i];
  return lowering.reshape(input, flat);
}

Expected<ValueId> lower_squeeze(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId input, lowering.input(node, 0));
  const Shape shape = lowering.shape(input);
  ROOMWISE_TRY(const auto given, integers_of(lowering, node, 1, "axes"));
  ROOMWISE_TRY(const auto axes, axes_of(given, shape.size()));
  std::vector<bool> drops(shape.size(), false);
  for (const std::size_t axis : axes) {
    if (shape[axis] != 1) return fail("the axis {} of {} is not 1", axis, shape_text(shape));
    drops[axis] = true;
  }
  Shape squeezed;
  for (std::size_t i = 0; i < shape.size(); ++i) {
    if (!(axes.empty() ? shape[i] == 1 : drops[i])) squeezed.push_back(shape[i]);
  }
  return lowering.reshape(input, squeezed);
}

Expected<ValueId> lower_unsqueeze(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId input, lowering.input(node, 0));
  const Shape shape = lowering.shape(input);
  ROOMWISE_TRY(const auto given, integers_of(lowering, node, 1, "axes"));
  ROOMWISE_TRY(const auto axes, axes_of(given, shape.size() + given.size()));
  std::vector<bool> is_new(shape.size() + axes.size(), false);
  for (const std::size_t axis : axes) is_new[axis] = true;
  Shape wider;
  for (std::size_t i = 0, old = 0; i < is_new.size(); ++i)
    wider.push_back(is_new[i] ? 1 : shape[old++]);
  return lowering.reshape(input, wider);
}

Expected<ValueId> lower_transpose(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId input, lowering.input(node, 0));
  const Shape shape = lowering.shape(input);
  std::vector<std::size_t> axes = range(0, shape.size());
  std::ranges::reverse(axes);
  if (node.find("perm") != nullptr) {
    ROOMWISE_TRY(axes, axes_of(node.integers("perm", {}), shape.size()));
    if (axes.size() != shape.size()) return fail("its axes are no permutation");
  }
  return lowering.permute(input, axes);
}

}  // namespace

const OperatorTable& shape_operators() {
  static const OperatorTable table = {
      {"Gather", lower_gather},       {"Concat", lower_concat},   {"Slice", lower_slice},
      {"Split", lower_split},         {"Pad", lower_pad},         {"Reshape", lower_reshape},
      {"Flatten", lower_flatten},     {"Squeeze", lower_squeeze}, {"Unsqueeze", lower_unsqueeze},
      {"Transpose", lower_transpose}, {"Resize", lower_resize},   {"Upsample", lower_resize},
      {"Expand", lower_expand},
  };
  return table;
}

}  // namespace roomwise::network
