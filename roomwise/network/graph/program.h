#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "roomwise/network/graph/onnx_graph.h"

namespace roomwise::network {

// A network for one input size: layers in the order of their work, every shape known. This is what
// the passes (passes.h) rewrite and what a plan (plan.h) is made of.

using ValueId = std::size_t;

// A number is held as the whole number nearest to number / step: 0 to 255, or -127 to 127.
struct EightBits {
  float step = 1;
  bool is_signed = false;

  friend bool operator==(const EightBits&, const EightBits&) = default;
};

struct Value {
  Shape shape;
  ConstantPointer constant = nullptr;  // absent: computed, or an input
  bool is_integer = false;  // of what is computed: whole numbers, held in floats (up to 2^24)
  std::optional<EightBits> eight_bits = std::nullopt;  // absent: 32-bit floats (quantization.h)
};

// An element-wise function.
struct Activation {
  enum class Function {
    kRelu,  // x, and alpha * x below zero
    kClip,  // between alpha and beta
    kSigmoid,
    kTanh,
    kExp,
    kSquareRoot,
    kPower,      // x^alpha
    kErf,        // Gauss' error function
    kLinear,     // alpha * x + beta
    kSwish,      // x * sigmoid(x)
    kHardSwish,  // x * clip(x / 6 + 1/2, 0, 1)
  };
  Function function = Function::kRelu;
  float alpha = 0;
  float beta = 0;
};

// How a window moves over height and width.
struct Window {
  std::array<std::int64_t, 2> kernel{1, 1};
  std::array<std::int64_t, 2> strides{1, 1};
  std::array<std::int64_t, 2> dilations{1, 1};  // 1: the window's places lie side by side
  std::array<std::int64_t, 2> pads_begin{0, 0};
  std::array<std::int64_t, 2> pads_end{0, 0};

  friend bool operator==(const Window&, const Window&) = default;
};

// Inputs: what is convolved and, where `adds_residual`, what is added to the result before the
// activations.
struct Convolution {
  ConstantPointer weights;  // outputs x inputs / groups x height x width
  std::vector<float> bias;  // empty: none
  std::int64_t groups = 1;
  Window window;
  bool adds_residual = false;
  std::vector<Activation> activations;  // one after the other

  // Whether each output's place is made of the same place of all inputs alone.
  [[nodiscard]] bool is_pointwise() const {
    return groups == 1 && window == Window{} && !adds_residual;
  }
};

struct Pooling {
  enum class Kind { kMaximum, kMean, kMeanIncludingPadding };
  Kind kind = Kind::kMaximum;
  Window window;
};

// Of two inputs whose shapes broadcast as NumPy's do. Comparisons give 1 or 0.
struct Arithmetic {
  enum class Operator { kAdd, kSubtract, kMultiply, kDivide, kMaximum, kMinimum, kEqual, kLess };
  Operator operation = Operator::kAdd;

  [[nodiscard]] bool commutes() const {
    return operation != Operator::kSubtract && operation != Operator::kDivide &&
           operation != Operator::kLess;
  }
  [[nodiscard]] bool compares() const {
    return operation == Operator::kEqual || operation == Operator::kLess;
  }
};

// The second input where the first is not 0, else the third. Their shapes broadcast.
struct Where {};

// The slices of the first input along `axis` that the second names; its axes stand in the place of
// that axis.
struct Gather {
  std::size_t axis = 0;
};

// Where along `axis`, which stays with the size 1, the largest value is (the first of several).
struct ArgMax {
  std::size_t axis = 0;
};

// The output's slices along `axis`, each a slice of an input or all `fill`: what joins, splits,
// slices, pads and shuffles. The inputs agree in all other sizes.
struct AxisSlices {
  static constexpr std::size_t kFill = static_cast<std::size_t>(-1);
  struct Pick {
    std::size_t input = 0;  // index into the layer's inputs, or kFill
    std::size_t index = 0;
    bool operator==(const Pick&) const = default;
  };
  std::size_t axis = 1;
  std::vector<Pick> slices;
  float fill = 0;
};

// rows x inner times inner x columns, plus a bias a column; leading sizes are batches.
struct MatrixProduct {
  std::vector<float> bias;  // empty: none
};

struct Softmax {
  std::size_t axis = 1;
};

// Another height and width: each value from two rows and two columns.
struct Resampling {
  struct Tap {
    std::size_t first = 0;
    std::size_t second = 0;
    float weight_of_second = 0;
  };
  std::vector<Tap> rows;
  std::vector<Tap> columns;
};

// The same values in the same order in another shape.
struct View {};

struct Permutation {
  std::vector<std::size_t> axes;  // the output's axis i is the input's axis axes[i]
};

// The mean over some axes, which stay with the size 1.
struct Mean {
  std::vector<std::size_t> axes;
};

struct Layer {
  std::variant<Convolution, Pooling, Activation, Arithmetic, AxisSlices, MatrixProduct, Softmax,
               Resampling, View, Permutation, Mean, Where, Gather, ArgMax>
      operation;
  std::vector<ValueId> inputs;
  ValueId output = 0;
  std::string node;  // of the file, for people

  template <typename Operation>
  [[nodiscard]] Operation* as() {
    return std::get_if<Operation>(&operation);
  }
  template <typename Operation>
  [[nodiscard]] const Operation* as() const {
    return std::get_if<Operation>(&operation);
  }
};

struct Program {
  std::vector<Value> values;
  std::vector<Layer> layers;
  std::vector<ValueId> inputs;
  std::vector<ValueId> outputs;
};

[[nodiscard]] std::size_t element_count(const Shape& shape);
// Fails where a value of this shape would be larger than anything that a network needs (a
// gigabyte).
[[nodiscard]] Expected<void> check_size(const Shape& shape);
// The shape that two shapes broadcast to. Fails where they do not.
[[nodiscard]] Expected<Shape> broadcast(const Shape& a, const Shape& b);
// By how many layers, and as an output, each value is used.
[[nodiscard]] std::vector<std::size_t> count_uses(const Program& program);

}  // namespace roomwise::network
