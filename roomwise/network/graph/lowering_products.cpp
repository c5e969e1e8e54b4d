// Products of matrices, and softmax.
#include <numeric>
#include <optional>

#include "roomwise/network/graph/lowering.h"

namespace roomwise::network {
namespace {

using Operator = Arithmetic::Operator;

// The value with its last two axes swapped.
Expected<ValueId> transposed(Lowering& lowering, ValueId value) {
  const Shape& shape = lowering.shape(value);
  if (shape.size() < 2) return fail("expected a matrix, not {}", shape_text(shape));
  std::vector<std::size_t> axes(shape.size());
  std::iota(axes.begin(), axes.end(), std::size_t{0});
  std::swap(axes[axes.size() - 1], axes[axes.size() - 2]);
  return lowering.permute(value, axes);
}

Expected<ValueId> scaled(Lowering& lowering, ValueId value, float factor) {
  if (factor == 1) return value;
  Constant constant;
  constant.floats = {factor};
  return lowering.arithmetic(Operator::kMultiply, value,
                             lowering.add_constant(std::move(constant)));
}

Expected<ValueId> product(Lowering& lowering, ValueId a, ValueId b, std::vector<float> bias) {
  Shape rows = lowering.shape(a);
  const Shape columns = lowering.shape(b);
  const std::size_t rank = rows.size();
  if (rank > 2 && columns.size() == 2) {
    // One product of all rows.
    Shape flat{1, rows.back()};
    for (std::size_t i = 0; i + 1 < rank; ++i) flat[0] *= rows[i];
    ROOMWISE_TRY(a, lowering.reshape(a, flat));
    ROOMWISE_TRY(const ValueId output, product(lowering, a, b, std::move(bias)));
    rows.back() = columns.back();
    return lowering.reshape(output, rows);
  }
  if (rank < 2 || columns.size() < 2 || columns.size() > rank ||
      rows[rank - 1] != columns[columns.size() - 2]) {
    return fail("cannot multiply {} by {}", shape_text(rows), shape_text(columns));
  }
  Shape of_b(rank - columns.size(), 1);
  of_b.insert(of_b.end(), columns.begin(), columns.end());
  for (std::size_t i = 0; i + 2 < rank; ++i) {
    if (of_b[i] != 1 && of_b[i] != rows[i])
      return fail("cannot multiply {} by {}", shape_text(rows), shape_text(columns));
  }
  ROOMWISE_TRY(b, lowering.reshape(b, of_b));
  rows[rank - 1] = of_b[rank - 1];
  return lowering.add(MatrixProduct{std::move(bias)}, {a, b}, std::move(rows));
}

Expected<ValueId> lower_matmul(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId a, lowering.input(node, 0));
  ROOMWISE_TRY(const ValueId b, lowering.input(node, 1));
  return product(lowering, a, b, {});
}

Expected<ValueId> lower_gemm(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(ValueId a, lowering.input(node, 0));
  ROOMWISE_TRY(ValueId b, lowering.input(node, 1));
  if (node.integer("transA", 0) != 0) {
    ROOMWISE_TRY(a, transposed(lowering, a));
  }
  if (node.integer("transB", 0) != 0) {
    ROOMWISE_TRY(b, transposed(lowering, b));
  }
  ROOMWISE_TRY(b, scaled(lowering, b, node.number("alpha", 1)));
  std::optional<ValueId> added;
  std::vector<float> bias;
  if (lowering.has_input(node, 2)) {
    ROOMWISE_TRY(const ValueId c, lowering.input(node, 2));
    ROOMWISE_TRY(added, scaled(lowering, c, node.number("beta", 1)));
    const ConstantPointer& known = lowering.constant(*added);
    if (known != nullptr && !known->is_integer && known->shape == Shape{lowering.shape(b).back()}) {
      bias = known->floats;
      added.reset();
    }
  }
  ROOMWISE_TRY(ValueId output, product(lowering, a, b, std::move(bias)));
  if (added) {
    ROOMWISE_TRY(output, lowering.arithmetic(Operator::kAdd, output, *added));
  }
  return output;
}

Expected<ValueId> lower_softmax(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId input, lowering.input(node, 0));
  const Shape shape = lowering.shape(input);
  const bool flattens = lowering.opset() < 13;  // everything from the axis on was one axis
  ROOMWISE_TRY(const std::size_t axis,
               axis_of(node.integer("axis", flattens ? 1 : -1), shape.size()));
  Shape worked_on = shape;
  if (flattens) {
    worked_on = {1, 1};
    for (std::size_t i = 0; i < shape.size(); ++i) worked_on[i < axis ? 0 : 1] *= shape[i];
  }
  ROOMWISE_TRY(ValueId value, lowering.reshape(input, worked_on));
  ROOMWISE_TRY(value, lowering.add(Softmax{flattens ? 1 : axis}, {value}, worked_on));
  ROOMWISE_TRY(value, lowering.reshape(value, shape));
  return value;
}

}  // namespace

const OperatorTable& product_operators() {
  static const OperatorTable table = {
      {"Gemm", lower_gemm},
      {"MatMul", lower_matmul},
      {"Softmax", lower_softmax},
  };
  return table;
}

}  // namespace roomwise::network
