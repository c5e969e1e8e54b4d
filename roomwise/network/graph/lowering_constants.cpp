// What is known beforehand: constants, shapes, casts; and what does nothing.
#include <algorithm>
#include <cmath>
#include <type_traits>

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
  ROOMWISE_RETURN_IF_ERROR(check_size(constant.shape));
  ROOMWISE_RETURN_IF_ERROR(lowering.check_constant_budget(element_count(constant.shape)));
  const Attribute* value = node.find("value");
  const Constant zero{{}, false, {0}, {}};
  const Constant& one = value != nullptr && value->tensor != nullptr ? *value->tensor : zero;
  if (one.size() != 1) return fail("expected a single number as value");
  constant.is_integer = one.is_integer;
  if (one.is_integer) constant.integers.assign(element_count(constant.shape), one.integers.front());
  if (!one.is_integer) constant.floats.assign(element_count(constant.shape), one.floats.front());
  return lowering.add_constant(std::move(constant));
}

Expected<ValueId> lower_shape(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId input, lowering.input(node, 0));
  const Shape& shape = lowering.shape(input);
  const auto rank = static_cast<std::int64_t>(shape.size());
  const auto place = [&](const char* attribute, std::int64_t otherwise) {
    const std::int64_t given = node.integer(attribute, otherwise);
    return std::clamp<std::int64_t>(given < 0 ? given + rank : given, 0, rank);
  };
  const std::int64_t start = place("start", 0), end = place("end", rank);
  Constant constant;
  constant.is_integer = true;
  if (start < end) constant.integers.assign(shape.begin() + start, shape.begin() + end);
  constant.shape = {static_cast<std::int64_t>(constant.integers.size())};
  return lowering.add_constant(std::move(constant));
}

// Equal to zero, as a truth value.
Expected<ValueId> is_zero(Lowering& lowering, ValueId value) {
  Constant zero;
  zero.is_integer = lowering.is_integer(value);
  if (zero.is_integer) zero.integers = {0};
  if (!zero.is_integer) zero.floats = {0};
  return lowering.arithmetic(Arithmetic::Operator::kEqual, value,
                             lowering.add_constant(std::move(zero)));
}

Expected<ValueId> differs_from_zero(Lowering& lowering, ValueId value) {
  ROOMWISE_TRY(const ValueId zero, is_zero(lowering, value));
  return is_zero(lowering, zero);
}

Expected<ValueId> lower_not(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId input, lowering.input(node, 0));
  return is_zero(lowering, input);
}

// The numbers from a first one, a step apart, as long as they are before a last one.
template <typename Number>
Expected<std::vector<Number>> numbers_between(Number first, Number end, Number step) {
  if (step == 0) return fail("its step is 0");
  const double count = std::ceil((static_cast<double>(end) - static_cast<double>(first)) /
                                 static_cast<double>(step));
  constexpr double kMax = 1 << 24;
  if (!(count <= kMax)) return fail("asks for {} numbers", count);
  std::vector<Number> numbers;
  for (std::int64_t i = 0; static_cast<double>(i) < count; ++i) {
    if constexpr (std::is_integral_v<Number>) {  // without undefined overflow
      numbers.push_back(
          static_cast<Number>(static_cast<std::uint64_t>(first) +
                              static_cast<std::uint64_t>(i) * static_cast<std::uint64_t>(step)));
    } else {
      numbers.push_back(first + static_cast<Number>(i) * step);
    }
  }
  return numbers;
}

Expected<ValueId> lower_range(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ConstantPointer first, lowering.constant_input(node, 0));
  ROOMWISE_TRY(const ConstantPointer end, lowering.constant_input(node, 1));
  ROOMWISE_TRY(const ConstantPointer step, lowering.constant_input(node, 2));
  for (const ConstantPointer& each : {first, end, step}) {
    if (each->size() != 1 || each->is_integer != first->is_integer)
      return fail("expected three single numbers of one kind");
  }
  Constant range;
  range.is_integer = first->is_integer;
  if (range.is_integer) {
    ROOMWISE_TRY(range.integers,
                 numbers_between(first->integers[0], end->integers[0], step->integers[0]));
  } else {
    ROOMWISE_TRY(range.floats, numbers_between(first->floats[0], end->floats[0], step->floats[0]));
  }
  range.shape = {static_cast<std::int64_t>(range.size())};
  return lowering.add_constant(std::move(range));
}

// A matrix (the last two axes) with zeros below or above a diagonal.
Expected<ValueId> lower_triangle(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ConstantPointer known, lowering.constant_input(node, 0));
  const bool upper = node.integer("upper", 1) != 0;
  std::int64_t diagonal = 0;
  if (lowering.has_input(node, 1)) {
    ROOMWISE_TRY(const auto given, lowering.integers_input(node, 1));
    if (given.size() != 1) return fail("expected a single number as diagonal");
    diagonal = std::clamp<std::int64_t>(given.front(), -(1 << 30), 1 << 30);
  }
  Constant triangle = *known;
  if (triangle.shape.size() < 2) return fail("expected a matrix, not {}", shape_text(known->shape));
  const std::int64_t columns = triangle.shape.back(), rows = triangle.shape.end()[-2];
  for (std::size_t i = 0; i < triangle.size(); ++i) {
    const auto at = static_cast<std::int64_t>(i);
    const std::int64_t row = at / columns % rows, column = at % columns;
    if (upper ? column >= row + diagonal : column <= row + diagonal) continue;
    if (triangle.is_integer) triangle.integers[i] = 0;
    if (!triangle.is_integer) triangle.floats[i] = 0;
  }
  return lowering.add_constant(std::move(triangle));
}

Expected<ValueId> lower_cast(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId input, lowering.input(node, 0));
  // TensorProto.DataType: 1, 10, 11 are floating-point numbers; 6, 7 whole ones, 9 truth values.
  const std::int64_t to = node.integer("to", 0);
  const bool to_float = to == 1 || to == 10 || to == 11;
  if (!to_float && to != 6 && to != 7 && to != 9)
    return fail("to the type {} is not supported", to);
  if (to == 9) return differs_from_zero(lowering, input);
  const ConstantPointer known = lowering.constant(input);
  if (known == nullptr) {
    if (!to_float && !lowering.is_integer(input))
      return fail("of what depends on the picture to whole numbers is not supported");
    return lowering.with_type(input, !to_float);
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
      {"Range", lower_range},       {"Trilu", lower_triangle},
      {"Not", lower_not},
  };
  return table;
}

}  // namespace roomwise::network
