#pragma once

#include <map>
#include <optional>

#include "roomwise/network/executor/plan.h"
#include "roomwise/network/executor/plan_primitives.h"

namespace roomwise::network {

// As many channels as a register of the processor holds numbers: what oneDNN's own kernels are
// written for.
[[nodiscard]] std::size_t channels_in_block(dnnl::cpu_isa isa);
// The largest weight of a convolution in 8 bits whose sums cannot overflow on the way.
[[nodiscard]] int max_weight_in_eight_bits(dnnl::cpu_isa isa);

// Makes a plan layer by layer. Feature maps (batch x channels x height x width) are kept in blocks
// of channels as wide as the processor's registers, all else row by row; what a primitive wants
// otherwise is reordered, once for each layout.
class PlanBuilder {
 public:
  PlanBuilder(const Program& program, const PlanOptions& options);
  [[nodiscard]] std::shared_ptr<const Plan> build();
  // The node in work.
  [[nodiscard]] std::string node() const;

 private:
  using Layout = dnnl::memory::desc;
  // A value that is written straight to into the value that concatenates it with others.
  struct ConcatSlot {
    ValueId target = 0;
    std::size_t values_before = 0;
  };

  void plan_concats();
  void plan_concat(const Layer& layer);

  [[nodiscard]] Layout plain(const Shape& shape) const;
  [[nodiscard]] Layout blocked(const Shape& shape) const;
  [[nodiscard]] Layout usual(const Shape& shape) const;
  [[nodiscard]] bool is_blocked(ValueId value);
  [[nodiscard]] const Shape& shape(ValueId value) const { return program_.values[value].shape; }
  [[nodiscard]] dnnl::memory constant_memory(const Layout& layout,
                                             const std::vector<float>& data) const;
  [[nodiscard]] dnnl::memory given_weights(const Convolution& convolution) const;
  [[nodiscard]] dnnl::memory reordered(dnnl::memory from, const Layout& layout,
                                       const dnnl::primitive_attr& attributes = {});
  [[nodiscard]] TensorView add_constant(dnnl::memory memory);

  // The value as it lies, and in a layout (reordered if need be).
  [[nodiscard]] TensorView located(ValueId value);
  [[nodiscard]] TensorView in_layout(ValueId value, const Layout& layout);
  [[nodiscard]] TensorView in_floats(ValueId value);
  // What numbers of a value are multiplied by from one layout to the other: its step, or 1.
  [[nodiscard]] float scale_between(ValueId value, const Layout& from, const Layout& to) const;
  [[nodiscard]] TensorView new_buffer(const Layout& layout);
  // Where a new value of this layout is written.
  [[nodiscard]] TensorView place_output(ValueId value, const Layout& layout);
  [[nodiscard]] Place place_of_join(ValueId target);
  void copy(const TensorView& from, const TensorView& to, float scale);
  void add_primitive(const dnnl::primitive& primitive, const Layout& scratchpad,
                     std::vector<PlannedOp::Operand> operands);
  void add_kernel(Kernel kernel, std::vector<TensorView> operands);

  void plan_layer(const Layer& layer, const Convolution& convolution);
  void plan_layer(const Layer& layer, const Pooling& pooling);
  void plan_layer(const Layer& layer, const Activation& activation);
  void plan_layer(const Layer& layer, const Arithmetic& arithmetic);
  void plan_layer(const Layer& layer, const AxisSlices& gather);
  void plan_layer(const Layer& layer, const MatrixProduct& product);
  void plan_layer(const Layer& layer, const Softmax& softmax);
  void plan_layer(const Layer& layer, const Resampling& resampling);
  void plan_layer(const Layer& layer, const View& view);
  void plan_layer(const Layer& layer, const Permutation& permutation);
  void plan_layer(const Layer& layer, const Mean& mean);
  void plan_layer(const Layer& layer, const Where& selection);
  void plan_layer(const Layer& layer, const Gather& lookup);
  void plan_layer(const Layer& layer, const ArgMax& largest);
  // A kernel that takes and gives values row by row.
  void add_plain_kernel(const Layer& layer, Kernel kernel);
  void add_convolution(const Layer& layer, const ConvolutionDescription& description,
                       const dnnl::memory& weights, const std::vector<float>& bias);
  [[nodiscard]] TensorView residual_in_place(const Layer& layer, const Layout& layout);
  void gather_in_place(const Layer& layer);

  // In 8 bits, channels last (plan_quantized.cpp). The layout of a value that is held so.
  [[nodiscard]] Layout in_eight_bits(ValueId value) const;
  // False where the layer's input is held in floats, or oneDNN has no fast way for it.
  [[nodiscard]] bool plan_in_eight_bits(const Layer& layer, const Convolution& convolution);
  [[nodiscard]] Layout quantized_output(const Layer& layer, const Convolution& convolution) const;
  [[nodiscard]] bool propagates_eight_bits(const Layer& layer) const;
  void join_in_eight_bits(const Layer& layer);

  void plan_memory_of_steps();

  const Program& program_;
  PlanOptions options_;
  std::size_t block_;
  std::shared_ptr<Plan> plan_ = std::make_shared<Plan>();
  dnnl::stream stream_;
  std::vector<std::optional<TensorView>> located_;         // by value, as it was made
  std::map<ValueId, std::vector<TensorView>> reordered_;   // the same in further layouts
  std::vector<std::size_t> last_use_;                      // by value: the last layer that reads it
  std::vector<bool> shares_memory_;                        // by value: with another value
  std::vector<std::optional<ConcatSlot>> concats_;         // by value
  std::map<ValueId, std::optional<Place>> concat_places_;  // by target; set when first needed
  std::vector<Buffer> buffers_;
  std::size_t layer_ = 0;  // in work
};

}  // namespace roomwise::network
