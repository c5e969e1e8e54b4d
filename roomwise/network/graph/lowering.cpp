#include "roomwise/network/graph/lowering.h"

#include <algorithm>
#include <numeric>

#include "roomwise/network/graph/constant_math.h"

namespace roomwise::network {

bool Lowering::has_input(const Node& node, std::size_t i) const {
  return i < node.inputs.size() && !node.inputs[i].empty();
}

Expected<ValueId> Lowering::input(const Node& node, std::size_t i) const {
  if (!has_input(node, i)) return fail("lacks its input {}", i);
  const auto found = values_.find(node.inputs[i]);
  if (found == values_.end()) return fail("nothing before it gives \"{}\"", node.inputs[i]);
  return found->second;
}

Expected<ConstantPointer> Lowering::constant_input(const Node& node, std::size_t i) const {
  ROOMWISE_TRY(const ValueId value, input(node, i));
  if (constant(value) == nullptr) {
    return fail("its input \"{}\" depends on the picture; it must be known beforehand",
                node.inputs[i]);
  }
  return constant(value);
}

Expected<std::vector<std::int64_t>> Lowering::integers_input(const Node& node,
                                                             std::size_t i) const {
  ROOMWISE_TRY(const ConstantPointer values, constant_input(node, i));
  if (!values->is_integer) return fail("its input \"{}\" holds no whole numbers", node.inputs[i]);
  return values->integers;
}

Expected<std::vector<float>> Lowering::floats_input(const Node& node, std::size_t i) const {
  ROOMWISE_TRY(const ConstantPointer values, constant_input(node, i));
  if (values->is_integer) return fail("its input \"{}\" holds whole numbers", node.inputs[i]);
  return values->floats;
}

// Whether a layer gives whole numbers. Fails where it takes none but gets some, or gets both kinds.
Expected<bool> Lowering::gives_integers(const decltype(Layer::operation)& operation,
                                        std::span<const ValueId> inputs) const {
  const auto integers = [&](ValueId value) { return is_integer(value); };
  if (std::holds_alternative<ArgMax>(operation)) return true;
  // A condition and indices are whole numbers beside others.
  if (std::holds_alternative<Gather>(operation)) inputs = inputs.first(1);
  if (std::holds_alternative<Where>(operation)) inputs = inputs.subspan(1);
  if (std::ranges::none_of(inputs, integers)) {
    const auto* arithmetic = std::get_if<Arithmetic>(&operation);
    return arithmetic != nullptr && arithmetic->compares();
  }
  const auto* arithmetic = std::get_if<Arithmetic>(&operation);
  if (arithmetic != nullptr && arithmetic->operation == Arithmetic::Operator::kDivide)
    return fail("divides whole numbers that depend on the input");
  const bool may_be_whole =
      arithmetic != nullptr || std::holds_alternative<AxisSlices>(operation) ||
      std::holds_alternative<View>(operation) || std::holds_alternative<Permutation>(operation) ||
      std::holds_alternative<Gather>(operation) || std::holds_alternative<Where>(operation);
  if (!may_be_whole || !std::ranges::all_of(inputs, integers))
    return fail("works on whole numbers, which only shapes and indices may be");
  return true;
}

// Whole numbers that are known beforehand as layers take them.
Expected<ValueId> Lowering::in_floats(ValueId value) {
  const ConstantPointer known = constant(value);
  if (known == nullptr || !known->is_integer) return value;
  constexpr std::int64_t kMax = std::int64_t{1} << 24;
  Constant floats;
  floats.shape = known->shape;
  for (const std::int64_t number : known->integers) {
    if (number < -kMax || number > kMax)
      return fail("the whole number {} is too large to be held exactly", number);
    floats.floats.push_back(static_cast<float>(number));
  }
  return add_constant(std::move(floats));
}

Expected<ValueId> Lowering::add(decltype(Layer::operation) operation, std::vector<ValueId> inputs,
                                Shape output_shape) {
  ROOMWISE_RETURN_IF_ERROR(check_size(output_shape));
  ROOMWISE_TRY(const bool integers, gives_integers(operation, inputs));
  for (ValueId& input : inputs) {
    ROOMWISE_TRY(input, in_floats(input));
  }
  if (element_count(output_shape) == 0) return fail("gives an empty value");
  if (const auto* gather = std::get_if<AxisSlices>(&operation))
    constant_elements_ += gather->slices.size();
  program_.values.push_back({std::move(output_shape), nullptr, integers});
  const ValueId output = program_.values.size() - 1;
  program_.layers.push_back({std::move(operation), std::move(inputs), output, node_});
  return output;
}

Expected<void> Lowering::check_constant_budget(std::size_t more) const {
  if (constant_elements_ + more > max_constant_elements_)
    return fail("asks for more constants than any network needs");
  return {};
}

ValueId Lowering::add_constant(Constant constant) {
  constant_elements_ += constant.size();
  Shape shape = constant.shape;
  program_.values.push_back(
      {std::move(shape), std::make_shared<const Constant>(std::move(constant))});
  return program_.values.size() - 1;
}

Expected<ValueId> Lowering::reshape(ValueId value, const Shape& to) {
  if (shape(value) == to) return value;
  ROOMWISE_RETURN_IF_ERROR(check_size(to));
  if (element_count(shape(value)) != element_count(to)) {
    return fail("cannot bring {} into the shape {}", shape_text(shape(value)), shape_text(to));
  }
  if (constant(value) == nullptr) return add(View{}, {value}, to);
  Constant same = *constant(value);
  same.shape = to;
  return add_constant(std::move(same));
}

Expected<ValueId> Lowering::pick(ValueId value, std::size_t axis,
                                 std::span<const std::size_t> indices) {
  Shape picked = shape(value);
  picked[axis] = static_cast<std::int64_t>(indices.size());
  ROOMWISE_RETURN_IF_ERROR(check_size(picked));
  if (constant(value) != nullptr) {
    ROOMWISE_RETURN_IF_ERROR(check_constant_budget(element_count(picked)));
    return add_constant(network::pick(*constant(value), axis, indices));
  }
  AxisSlices gather;
  gather.axis = axis;
  for (const std::size_t index : indices) gather.slices.push_back({0, index});
  return add(std::move(gather), {value}, std::move(picked));
}

Expected<ValueId> Lowering::permute(ValueId value, const std::vector<std::size_t>& axes) {
  if (constant(value) != nullptr) return add_constant(network::permute(*constant(value), axes));
  Shape moved;
  for (const std::size_t axis : axes) moved.push_back(shape(value)[axis]);
  return add(Permutation{axes}, {value}, std::move(moved));
}

Expected<ValueId> Lowering::arithmetic(Arithmetic::Operator operation, ValueId a, ValueId b) {
  ROOMWISE_TRY(Shape result, broadcast(shape(a), shape(b)));
  if (constant(a) != nullptr && constant(b) != nullptr &&
      (fold_constants_ || constant(a)->is_integer)) {
    ROOMWISE_TRY(Constant computed, compute(operation, *constant(a), *constant(b)));
    return add_constant(std::move(computed));
  }
  ROOMWISE_TRY(a, with_rank(a, result.size()));
  ROOMWISE_TRY(b, with_rank(b, result.size()));
  return add(Arithmetic{operation}, {a, b}, std::move(result));
}

// With axes of the size 1 in front.
Expected<ValueId> Lowering::with_rank(ValueId value, std::size_t rank) {
  Shape padded(rank - shape(value).size(), 1);
  padded.insert(padded.end(), shape(value).begin(), shape(value).end());
  return reshape(value, padded);
}

Expected<ValueId> Lowering::select(ValueId condition, ValueId a, ValueId b) {
  if (!is_integer(condition)) return fail("its condition is no truth value");
  if (constant(condition) != nullptr && constant(a) != nullptr && constant(b) != nullptr) {
    ROOMWISE_TRY(Constant selected,
                 network::select(*constant(condition), *constant(a), *constant(b)));
    return add_constant(std::move(selected));
  }
  ROOMWISE_TRY(const Shape of_both, broadcast(shape(a), shape(b)));
  ROOMWISE_TRY(Shape result, broadcast(shape(condition), of_both));
  return add(Where{}, {condition, a, b}, std::move(result));
}

Expected<ValueId> Lowering::expand(ValueId value, const Shape& wanted) {
  ROOMWISE_TRY(const Shape result, broadcast(shape(value), wanted));
  ROOMWISE_TRY(value, with_rank(value, result.size()));
  for (std::size_t axis = 0; axis < result.size(); ++axis) {
    if (shape(value)[axis] == result[axis]) continue;
    ROOMWISE_RETURN_IF_ERROR(check_constant_budget(static_cast<std::size_t>(result[axis])));
    const std::vector<std::size_t> repeated(static_cast<std::size_t>(result[axis]), 0);
    ROOMWISE_TRY(value, pick(value, axis, repeated));
  }
  return value;
}

ValueId Lowering::add_number(float number) {
  Constant constant;
  constant.floats = {number};
  return add_constant(std::move(constant));
}

Expected<ValueId> Lowering::with_type(ValueId value, bool integers) {
  if (is_integer(value) == integers) return value;
  program_.values.push_back({shape(value), nullptr, integers});
  const ValueId output = program_.values.size() - 1;
  program_.layers.push_back({View{}, {value}, output, node_});
  return output;
}

Expected<ValueId> Lowering::mean(ValueId value, std::vector<std::size_t> axes) {
  Shape reduced = shape(value);
  for (const std::size_t axis : axes) reduced[axis] = 1;
  std::ranges::sort(axes);
  if (reduced.size() == 4 && axes == std::vector<std::size_t>{2, 3}) {
    Pooling pooling;
    pooling.kind = Pooling::Kind::kMean;
    pooling.window.kernel = {shape(value)[2], shape(value)[3]};
    return add(pooling, {value}, std::move(reduced));
  }
  return add(Mean{std::move(axes)}, {value}, std::move(reduced));
}

void Lowering::set_output(const Node& node, std::size_t i, ValueId value) {
  if (i < node.outputs.size() && !node.outputs[i].empty()) values_[node.outputs[i]] = value;
}

Expected<void> Lowering::lower_node(const Node& node) {
  node_ = node.name.empty() && !node.outputs.empty() ? node.outputs.front() : node.name;
  const std::string who =
      fmt::format("node \"{}\" ({}, opset {})", node_, node.operation, graph_.opset);
  const auto in_node = [&](Error error) { return std::move(error).with_context(who); };
  if (node.domain.empty() || node.domain == "ai.onnx") {
    for (const OperatorTable* table :
         {&layer_operators(), &product_operators(), &shape_operators(), &constant_operators()}) {
      if (const auto found = table->find(node.operation); found != table->end()) {
        ROOMWISE_TRY(const ValueId output, found->second(*this, node).map_error(in_node));
        set_output(node, 0, output);
        return {};
      }
    }
  }
  return fail("{}: the operator is not supported{}", who,
              node.domain.empty() ? "" : fmt::format(" (of \"{}\")", node.domain));
}

Expected<ValueId> Lowering::find_output(const std::string& name) const {
  if (const auto found = values_.find(name); found != values_.end()) return found->second;
  for (const Node& node : graph_.nodes) {
    if (node.name != name || node.outputs.empty()) continue;
    if (const auto found = values_.find(node.outputs.front()); found != values_.end())
      return found->second;
  }
  return fail("the network has no output or node named \"{}\"; its outputs are {}", name,
              fmt::join(graph_.outputs, ", "));
}

Expected<Program> Lowering::run(std::span<const Shape> input_shapes,
                                std::span<const std::string> outputs) {
  if (input_shapes.size() != graph_.inputs.size()) {
    return fail("the network has {} inputs, not {}", graph_.inputs.size(), input_shapes.size());
  }
  if (graph_.opset < 10 || graph_.opset > 17) {
    return fail("the network is of opset {}; 10 to 17 are understood", graph_.opset);
  }
  for (const auto& [name, constant] : graph_.constants) {
    program_.values.push_back({constant->shape, constant});
    values_[name] = program_.values.size() - 1;
  }
  for (std::size_t i = 0; i < input_shapes.size(); ++i) {
    ROOMWISE_RETURN_IF_ERROR(check_size(input_shapes[i]));
    program_.values.push_back({input_shapes[i], nullptr, graph_.inputs[i].is_integer});
    program_.inputs.push_back(program_.values.size() - 1);
    values_[graph_.inputs[i].name] = program_.inputs.back();
  }
  for (const auto& [name, constant] : graph_.constants)
    max_constant_elements_ += 4 * constant->size();
  for (const Node& node : graph_.nodes) {
    ROOMWISE_RETURN_IF_ERROR(lower_node(node));
    ROOMWISE_RETURN_IF_ERROR(check_constant_budget());
  }
  for (const std::string& name :
       outputs.empty() ? std::span<const std::string>(graph_.outputs) : outputs) {
    ROOMWISE_TRY(const ValueId output, find_output(name));
    if (constant(output) != nullptr && constant(output)->is_integer) {
      return fail("the output \"{}\" holds whole numbers", name);
    }
    program_.outputs.push_back(output);
  }
  return std::move(program_);
}

Expected<Program> lower(const OnnxGraph& graph, std::span<const Shape> input_shapes,
                        std::span<const std::string> outputs, bool fold_constants) {
  return Lowering(graph, fold_constants).run(input_shapes, outputs);
}

Expected<std::size_t> axis_of(std::int64_t axis, std::size_t rank) {
  const auto size = static_cast<std::int64_t>(rank);
  if (axis < -size || axis >= size) return fail("has no axis {} among {}", axis, rank);
  return static_cast<std::size_t>(axis < 0 ? axis + size : axis);
}

Expected<std::vector<std::size_t>> axes_of(std::span<const std::int64_t> axes, std::size_t rank) {
  std::vector<std::size_t> named;
  for (const std::int64_t axis : axes) {
    ROOMWISE_TRY(const std::size_t place, axis_of(axis, rank));
    if (std::ranges::find(named, place) != named.end())
      return fail("names the axis {} twice", place);
    named.push_back(place);
  }
  return named;
}

}  // namespace roomwise::network
