// What is known beforehand: constants, shapes, casts; and what does nothing.
#include <cmath>

#include "roomwise/network/graph/lowering.h"

namespace roomwise::network {
namespace {

Expected<ValueId> lower_identity(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId input, lowering.input(node, 0));
  return input;
}

Expected<ValueId> lower_constant(Lowering& lowering, const Node& node) {
  Constant constant;
  if (const Attribute* value = node.find("value"); value != nullptr && value->tensor != nullptr) {
    constant = *value->tensor;
  } else if (const Attribute* number = node.find("value_float")) {
    constant.floats = {number->number};
  } else if (const Attribute* integer = node.find("value_int")) {
    constant.is_integer = true;
    constant.integers = {integer->integer};
  } else if (const Attribute* numbers = node.find("value_floats")) {
    constant.floats = numbers->numbers;
    constant.shape = {static_cast<std::int64_t>(numbers->numbers.size())};
  } else if (const Attribute* integers = node.find("value_ints")) {
    constant.is_integer = true;
    constant.integers = integers->integers;
    constant.shape = {static_cast<std::int64_t>(integers->integers.size())};
  } else {
    return fail("holds no numbers");
  }
  return lowering.add_constant(std::move(constant));
}

Expected<ValueId> lower_constant_of_shape(Lowering& lowering, const Node& node) {
  Constant constant;
  ROOMWISE_TRY(constant.shape, lowering.integers_input(node, 0));
  ROOMWISE_CHECK_OK(check_size(constant.shape));
  const Attribute* value = node.find("value");
  const Constant zero{{}, false, {0}, {}};
  const Constant& one = value != nullptr && value->tensor != nullptr ? *value->tensor : zero;
  if (one.size() != 1) return fail("expected a single number as value");
  constant.is_integer = one.is_integer;
  if (one.is_integer) constant.integers.assign(count_of(constant.shape), one.integers.front());
  if (!one.is_integer) constant.floats.assign(count_of(constant.shape), one.floats.front());
  return lowering.add_constant(std::move(constant));
}

Expected<ValueId> lower_shape(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId input, lowering.input(node, 0));
  if (node.find("start") != nullptr || node.find("end") != nullptr)
    return fail("a part of a shape is not supported");
  Constant constant;
  constant.is_integer = true;
  constant.integers = lowering.shape(input);
  constant.shape = {static_cast<std::int64_t>(constant.integers.size())};
  return lowering.add_constant(std::move(constant));
}

Expected<ValueId> lower_cast(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId input, lowering.input(node, 0));
  // TensorProto.DataType: 1, 10, 11 are floating-point numbers; 6, 7 whole ones.
  const std::int64_t to = node.integer("to", 0);
  const bool to_float = to == 1 || to == 10 || to == 11;
  if (!to_float && to != 6 && to != 7) return fail("to the type {} is not supported", to);
  const ConstantPointer known = lowering.constant(input);
  if (known == nullptr) {
    if (!to_float) return fail("of what depends on the picture to whole numbers is not supported");
    return input;
  }
  Constant cast = *known;
  cast.is_integer = !to_float;
  if (to_float && known->is_integer) {
    cast.floats.assign(known->integers.begin(), known->integers.end());
    cast.integers.clear();
  } else if (!to_float && !known->is_integer) {
    for (const float value : known->floats) {
      if (!(std::abs(value) < 9e18F)) return fail("{} is no whole number", value);
      cast.integers.push_back(static_cast<std::int64_t>(value));
    }
    cast.floats.clear();
  }
  return lowering.add_constant(std::move(cast));
}

Expected<ValueId> lower_rounding(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ConstantPointer known, lowering.constant_input(node, 0));
  Constant rounded = *known;
  for (float& value : rounded.floats) {
    value = node.operation == "Floor" ? std::floor(value) : std::ceil(value);
  }
  return lowering.add_constant(std::move(rounded));
}

}  // namespace

const OperatorTable& constant_operators() {
  static const OperatorTable table = {
      {"Identity", lower_identity}, {"Dropout", lower_identity},
      {"Constant", lower_constant}, {"ConstantOfShape", lower_constant_of_shape},
      {"Shape", lower_shape},       {"Cast", lower_cast},
      {"Floor", lower_rounding},    {"Ceil", lower_rounding},
  };
  return table;
}

}  // namespace roomwise::network
