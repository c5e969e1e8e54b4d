#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "roomwise/network/graph/program.h"

namespace roomwise::network {

// The program of a graph for inputs of these shapes (one each, in the graph's order, no free
// sizes), with these outputs (names of values or nodes; none: the graph's own). What depends on
// constants and shapes alone is worked out here; `fold_constants` does so for floating-point
// arithmetic too. Fails, naming node, operator and opset, on what is not understood, and on values
// larger than check_size() allows.
[[nodiscard]] Expected<Program> lower(const OnnxGraph& graph, std::span<const Shape> input_shapes,
                                      std::span<const std::string> outputs,
                                      bool fold_constants = true);

// What the functions that lower one operator each work with.
class Lowering {
 public:
  Lowering(const OnnxGraph& graph, bool fold_constants)
      : graph_(graph), fold_constants_(fold_constants) {}

  [[nodiscard]] Expected<Program> run(std::span<const Shape> input_shapes,
                                      std::span<const std::string> outputs);

  [[nodiscard]] std::int64_t opset() const { return graph_.opset; }
  [[nodiscard]] bool folds_constants() const { return fold_constants_; }
  [[nodiscard]] const Shape& shape(ValueId value) const { return program_.values[value].shape; }
  [[nodiscard]] const ConstantPointer& constant(ValueId value) const {
    return program_.values[value].constant;
  }
  // Whether it holds whole numbers.
  [[nodiscard]] bool is_integer(ValueId value) const {
    return constant(value) != nullptr ? constant(value)->is_integer
                                      : program_.values[value].is_integer;
  }

  // The node's input i. has_input(): it is there.
  [[nodiscard]] bool has_input(const Node& node, std::size_t i) const;
  [[nodiscard]] Expected<ValueId> input(const Node& node, std::size_t i) const;
  // The node's input i, which must be known beforehand.
  [[nodiscard]] Expected<ConstantPointer> constant_input(const Node& node, std::size_t i) const;
  [[nodiscard]] Expected<std::vector<std::int64_t>> integers_input(const Node& node,
                                                                   std::size_t i) const;
  [[nodiscard]] Expected<std::vector<float>> floats_input(const Node& node, std::size_t i) const;

  // Adds a layer (of the node in work) and gives its output.
  [[nodiscard]] Expected<ValueId> add(decltype(Layer::operation) operation,
                                      std::vector<ValueId> inputs, Shape output_shape);
  [[nodiscard]] ValueId add_constant(Constant constant);
  // The value with another shape of as many values; a constant stays one.
  [[nodiscard]] Expected<ValueId> reshape(ValueId value, const Shape& shape);
  // The slices `indices` of the value along an axis.
  [[nodiscard]] Expected<ValueId> pick(ValueId value, std::size_t axis,
                                       std::span<const std::size_t> indices);
  [[nodiscard]] Expected<ValueId> arithmetic(Arithmetic::Operator operation, ValueId a, ValueId b);
  // The first value where `condition` is not 0, else the second.
  [[nodiscard]] Expected<ValueId> select(ValueId condition, ValueId a, ValueId b);
  // The value repeated along axes of the size 1 until it has this shape.
  [[nodiscard]] Expected<ValueId> expand(ValueId value, const Shape& shape);
  // A single number.
  [[nodiscard]] ValueId add_number(float number);
  // What is computed, as floating-point numbers or as whole ones, which it must then be.
  [[nodiscard]] Expected<ValueId> with_type(ValueId value, bool is_integer);
  // The mean over axes, which stay with the size 1.
  [[nodiscard]] Expected<ValueId> mean(ValueId value, std::vector<std::size_t> axes);
  [[nodiscard]] Expected<ValueId> permute(ValueId value, const std::vector<std::size_t>& axes);
  // Fails where so many numbers or slices more than were written down so far are more than any
  // network needs: a small file can ask for more than any memory holds.
  [[nodiscard]] Expected<void> check_constant_budget(std::size_t more = 0) const;
  // Says what the node's output i is.
  void set_output(const Node& node, std::size_t i, ValueId value);

 private:
  [[nodiscard]] Expected<void> lower_node(const Node& node);
  [[nodiscard]] Expected<bool> gives_integers(const decltype(Layer::operation)& operation,
                                              std::span<const ValueId> inputs) const;
  [[nodiscard]] Expected<ValueId> in_floats(ValueId value);
  [[nodiscard]] Expected<ValueId> with_rank(ValueId value, std::size_t rank);
  [[nodiscard]] Expected<ValueId> find_output(const std::string& name) const;

  const OnnxGraph& graph_;
  bool fold_constants_;
  std::size_t constant_elements_ = 0;  // numbers and slices that were written down so far
  std::size_t max_constant_elements_ = std::size_t{1} << 24;
  Program program_;
  std::map<std::string, ValueId> values_;
  std::string node_;
};

// Gives the node's first output; further ones it sets itself.
using LowerNode = Expected<ValueId> (*)(Lowering&, const Node&);
using OperatorTable = std::map<std::string, LowerNode>;
// Convolutions, pooling, element-wise functions.
[[nodiscard]] const OperatorTable& layer_operators();
// Products of matrices, and softmax.
[[nodiscard]] const OperatorTable& product_operators();
// What moves, reshapes and slices values.
[[nodiscard]] const OperatorTable& shape_operators();
// What is known beforehand: constants, shapes, casts; and what does nothing.
[[nodiscard]] const OperatorTable& constant_operators();

// Another height and width (Resize, Upsample).
[[nodiscard]] Expected<ValueId> lower_resize(Lowering& lowering, const Node& node);

// The axis that a possibly negative number names. Fails where there is no such axis.
[[nodiscard]] Expected<std::size_t> axis_of(std::int64_t axis, std::size_t rank);
// The same for several numbers, which must name different axes.
[[nodiscard]] Expected<std::vector<std::size_t>> axes_of(std::span<const std::int64_t> axes,
                                                         std::size_t rank);

}  // namespace roomwise::network
