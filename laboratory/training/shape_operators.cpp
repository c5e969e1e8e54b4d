// What moves, reshapes and slices values.
#include <ATen/Functions.h>
#include <ATen/TensorOperators.h>

#include <algorithm>
#include <numeric>

#include "laboratory/training/operators.h"

namespace roomwise::training {
namespace {

// Whole numbers given by an input in newer opsets and by an attribute in older ones.
std::vector<std::int64_t> given(const Values& in, std::size_t i,
                                const std::vector<std::int64_t>& attribute) {
  return i < in.size() && in[i].defined() ? integers_of(in[i]) : attribute;
}

Expected<Operation> make_identity(const network::Node&, std::int64_t) {
  return [](const Values& in, bool) -> Values { return {in[0]}; };
}

// Drops values by libtorch's random numbers while the network learns.
Expected<Operation> make_dropout(const network::Node& node, std::int64_t opset) {
  const auto attribute = static_cast<double>(node.number("ratio", 0.5F));
  return [=](const Values& in, bool learning) -> Values {
    const bool given = opset >= 12 && in.size() > 1 && in[1].defined();
    return {at::dropout(in[0], given ? in[1].item<double>() : attribute, learning)};
  };
}

Expected<Operation> make_concat(const network::Node& node, std::int64_t) {
  const std::int64_t axis = node.integer("axis", 1);
  return [=](const Values& in, bool) -> Values { return {at::cat(in, axis)}; };
}

Expected<Operation> make_flatten(const network::Node& node, std::int64_t) {
  const std::int64_t named = node.integer("axis", 1);
  return [=](const Values& in, bool) -> Values {
    const std::int64_t axis = named < 0 ? named + in[0].dim() : named;
    const auto sizes = in[0].sizes().slice(0, static_cast<std::size_t>(axis));
    return {in[0].reshape({c10::multiply_integers(sizes), -1})};
  };
}

// The sizes that a Reshape gives its first input.
std::vector<std::int64_t> wanted_sizes(const Values& in) {
  TORCH_CHECK(in.size() == 2, "expected two inputs");
  std::vector<std::int64_t> sizes = integers_of(in[1]);
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    if (sizes[i] == 0) sizes[i] = in[0].size(static_cast<std::int64_t>(i));
  }
  return sizes;
}

// A file that fixes the batch at 1 says 1 where another batch is meant.
Expected<Operation> make_reshape(const network::Node&, std::int64_t) {
  return [](const Values& in, bool) -> Values {
    std::vector<std::int64_t> sizes = wanted_sizes(in);
    const bool batches = in[0].dim() > 0 && in[0].size(0) > 1 && !sizes.empty() && sizes[0] == 1;
    if (batches && in[0].is_floating_point()) sizes[0] = in[0].size(0);
    return {in[0].reshape(sizes)};
  };
}

Expected<Operation> make_squeeze(const network::Node& node, std::int64_t) {
  const auto attribute = node.integers("axes", {});
  return [=](const Values& in, bool) -> Values {
    auto axes = given(in, 1, attribute);
    if (axes.empty()) return {in[0].squeeze()};
    for (std::int64_t& axis : axes) axis += axis < 0 ? in[0].dim() : 0;
    std::ranges::sort(axes, std::greater());
    at::Tensor value = in[0];
    for (const std::int64_t axis : axes) value = value.squeeze(axis);
    return {value};
  };
}

Expected<Operation> make_unsqueeze(const network::Node& node, std::int64_t) {
  const auto attribute = node.integers("axes", {});
  return [=](const Values& in, bool) -> Values {
    auto axes = given(in, 1, attribute);
    const std::int64_t rank = in[0].dim() + std::ssize(axes);
    for (std::int64_t& axis : axes) axis += axis < 0 ? rank : 0;
    std::ranges::sort(axes);
    at::Tensor value = in[0];
    for (const std::int64_t axis : axes) value = value.unsqueeze(axis);
    return {value};
  };
}

Expected<Operation> make_transpose(const network::Node& node, std::int64_t) {
  const auto named = node.integers("perm", {});
  return [=](const Values& in, bool) -> Values {
    std::vector<std::int64_t> axes = named;
    for (std::int64_t axis = in[0].dim(); named.empty() && axis-- > 0;) axes.push_back(axis);
    return {in[0].permute(axes)};
  };
}

Expected<Operation> make_slice(const network::Node&, std::int64_t) {
  return [](const Values& in, bool) -> Values {
    TORCH_CHECK(in.size() >= 3, "expected starts and ends");
    const auto starts = integers_of(in[1]), ends = integers_of(in[2]);
    std::vector<std::int64_t> axes(starts.size()), steps(starts.size(), 1);
    std::iota(axes.begin(), axes.end(), 0);
    axes = given(in, 3, axes);
    steps = given(in, 4, steps);
    TORCH_CHECK(ends.size() == starts.size() && axes.size() == starts.size() &&
                    steps.size() == starts.size(),
                "its starts, ends, axes and steps are not of one number");
    at::Tensor value = in[0];
    for (std::size_t i = 0; i < starts.size(); ++i) {
      TORCH_CHECK(steps[i] > 0, "a slice backwards is not supported");
      value = at::slice(value, axes[i], starts[i], ends[i], steps[i]);
    }
    return {value};
  };
}

Expected<Operation> make_split(const network::Node& node, std::int64_t) {
  const std::int64_t axis = node.integer("axis", 0);
  const auto attribute = node.integers("split", {});
  const auto parts = static_cast<std::int64_t>(node.outputs.size());
  return [=](const Values& in, bool) -> Values {
    auto sizes = given(in, 1, attribute);
    if (sizes.empty()) sizes.assign(static_cast<std::size_t>(parts), in[0].size(axis) / parts);
    return at::split_with_sizes(in[0], sizes, axis);
  };
}

Expected<Operation> make_pad(const network::Node& node, std::int64_t opset) {
  if (node.text("mode", "constant") != "constant")
    return fail("its mode \"{}\" is not supported; \"constant\" is", node.text("mode", ""));
  const auto attribute = node.integers("pads", {});
  const auto number = static_cast<double>(node.number("value", 0));
  return [=](const Values& in, bool) -> Values {
    const auto pads = opset < 11 ? attribute : given(in, 1, {});
    const auto rank = static_cast<std::size_t>(in[0].dim());
    TORCH_CHECK(pads.size() == 2 * rank, "expected two pads an axis");
    const bool has_value = opset >= 11 && in.size() > 2 && in[2].defined();
    std::vector<std::int64_t> from_last;  // as libtorch wants them: the last axis first
    for (std::size_t axis = rank; axis-- > 0;) {
      from_last.push_back(pads[axis]);
      from_last.push_back(pads[rank + axis]);
    }
    return {at::constant_pad_nd(in[0], from_last, has_value ? in[2].item<double>() : number)};
  };
}

Expected<Operation> make_shape(const network::Node&, std::int64_t) {
  return [](const Values& in, bool) -> Values {
    return {at::tensor(in[0].sizes(), at::TensorOptions().dtype(at::kLong))};
  };
}

Expected<Operation> make_gather(const network::Node& node, std::int64_t) {
  const std::int64_t named = node.integer("axis", 0);
  return [=](const Values& in, bool) -> Values {
    TORCH_CHECK(in.size() == 2, "expected two inputs");
    const std::int64_t axis = named < 0 ? named + in[0].dim() : named;
    const at::Tensor flat = in[1].to(in[0].device()).flatten();
    const at::Tensor indices = at::where(flat < 0, flat + in[0].size(axis), flat);
    std::vector<std::int64_t> sizes = in[0].sizes().slice(0, static_cast<std::size_t>(axis)).vec();
    sizes.insert(sizes.end(), in[1].sizes().begin(), in[1].sizes().end());
    sizes.insert(sizes.end(), in[0].sizes().begin() + axis + 1, in[0].sizes().end());
    return {at::index_select(in[0], axis, indices).reshape(sizes)};
  };
}

Expected<Operation> make_cast(const network::Node& node, std::int64_t) {
  // TensorProto.DataType: 1, 10, 11 are floating-point numbers; 6, 7 whole ones.
  const std::int64_t to = node.integer("to", 0);
  const bool to_float = to == 1 || to == 10 || to == 11;
  if (!to_float && to != 6 && to != 7) return fail("to the type {} is not supported", to);
  return [=](const Values& in, bool) -> Values {
    return {in[0].to(to_float ? at::kFloat : at::kLong)};
  };
}

}  // namespace

std::vector<std::int64_t> integers_of(const at::Tensor& tensor) {
  const at::Tensor flat = tensor.to(at::kCPU, at::kLong).contiguous();
  const auto* values = flat.data_ptr<std::int64_t>();
  return {values, values + flat.numel()};
}

Operation reshape_of_constant() {
  return [](const Values& in, bool) -> Values { return {in[0].reshape(wanted_sizes(in))}; };
}

const OperatorTable& shape_operators() {
  static const OperatorTable table = {
      {"Identity", make_identity},
      {"Dropout", make_dropout},
      {"Concat", make_concat},
      {"Flatten", make_flatten},
      {"Reshape", make_reshape},
      {"Squeeze", make_squeeze},
      {"Unsqueeze", make_unsqueeze},
      {"Transpose", make_transpose},
      {"Slice", make_slice},
      {"Split", make_split},
      {"Pad", make_pad},
      {"Shape", make_shape},
      {"Gather", make_gather},
      {"Cast", make_cast},
  };
  return table;
}

Expected<Operation> make_operation(const network::Node& node, std::int64_t opset) {
  for (const OperatorTable* table : {&layer_operators(), &shape_operators()}) {
    const auto found = table->find(node.operation);
    if (found != table->end() && (node.domain.empty() || node.domain == "ai.onnx"))
      return found->second(node, opset);
  }
  return fail("the operator is not supported in training");
}

}  // namespace roomwise::training
