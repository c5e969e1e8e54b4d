#include "roomwise/network/executor/plan_builder.h"

#include <algorithm>
#include <cstring>

namespace roomwise::network {
namespace {

using dnnl::memory;

memory::dims dims_of_shape(const Shape& shape) {
  // oneDNN knows no single number.
  return shape.empty() ? memory::dims{1} : memory::dims(shape.begin(), shape.end());
}

}  // namespace

std::size_t channels_in_block(dnnl::cpu_isa isa) {
  // Sets of bits, not steps of a ladder: AVX2 with VNNI is a larger number than AVX-512.
  constexpr auto kAvx512 = static_cast<unsigned>(dnnl::cpu_isa::avx512_core);
  return (static_cast<unsigned>(isa) & kAvx512) == kAvx512 ? 16 : 8;
}

PlanBuilder::PlanBuilder(const Program& program, const PlanOptions& options)
    : program_(program),
      options_(options),
      block_(channels_in_block(dnnl::get_effective_cpu_isa())),
      stream_(plan_->engine),
      located_(program.values.size()),
      last_use_(program.values.size(), 0),
      shares_memory_(program.values.size(), false),
      concats_(program.values.size()) {}

std::shared_ptr<const Plan> PlanBuilder::build() {
  const ScopedOmpThreads threads(options_.threads);
  plan_->threads = options_.threads;
  for (const ValueId input : program_.inputs) {
    located_[input] = new_buffer(plain(shape(input)));
    plan_->inputs.push_back(*located_[input]);
    shares_memory_[input] = true;
  }
  for (std::size_t i = 0; i < program_.layers.size(); ++i) {
    for (const ValueId input : program_.layers[i].inputs) last_use_[input] = i;
  }
  for (const ValueId output : program_.outputs) last_use_[output] = program_.layers.size();
  if (options_.concat_in_place) plan_concats();
  for (layer_ = 0; layer_ < program_.layers.size(); ++layer_) {
    const Layer& layer = program_.layers[layer_];
    std::visit([&](const auto& operation) { plan_layer(layer, operation); }, layer.operation);
  }
  for (const ValueId output : program_.outputs) {
    plan_->outputs.push_back(in_layout(output, plain(shape(output))));
    plan_->output_shapes.push_back(shape(output));
  }
  plan_memory_of_steps();
  return std::move(plan_);
}

// Which values are written straight into what they are joined to: feature maps whose channels fill
// whole blocks, and other values that are concatenated along their first axis that is not 1.
void PlanBuilder::plan_concats() {
  for (const Layer& layer : program_.layers) {
    if (const AxisSlices* gather = layer.as<AxisSlices>();
        gather != nullptr && concatenates_whole_inputs(program_, layer) &&
        BlockedShape::around(shape(layer.output), gather->axis).outer == 1) {
      plan_concat(layer);
    }
  }
}

void PlanBuilder::plan_concat(const Layer& layer) {
  const bool in_blocks = shape(layer.output).size() == 4;
  if (in_blocks && layer.as<AxisSlices>()->axis != 1) return;
  const auto fills_blocks = [&](ValueId input) {
    return static_cast<std::size_t>(shape(input)[1]) % block_ == 0;
  };
  const auto all_but_last = std::span(layer.inputs).first(layer.inputs.size() - 1);
  if (in_blocks && !std::ranges::all_of(all_but_last, fills_blocks)) return;
  std::size_t values = 0;
  for (const ValueId input : layer.inputs) {
    const bool is_computed = program_.values[input].constant == nullptr && !shares_memory_[input];
    if (is_computed && !concats_[input]) concats_[input] = ConcatSlot{layer.output, values};
    values += element_count(shape(input));
  }
  concat_places_.insert({layer.output, std::nullopt});
}

PlanBuilder::Layout PlanBuilder::plain(const Shape& shape) const {
  memory::dims strides(std::max<std::size_t>(shape.size(), 1), 1);
  for (std::size_t i = strides.size() - 1; i > 0; --i) strides[i - 1] = strides[i] * shape[i];
  return {dims_of_shape(shape), memory::data_type::f32, strides};
}

PlanBuilder::Layout PlanBuilder::blocked(const Shape& shape) const {
  return {dims_of_shape(shape), memory::data_type::f32,
          block_ == 16 ? memory::format_tag::nChw16c : memory::format_tag::nChw8c};
}

PlanBuilder::Layout PlanBuilder::usual(const Shape& shape) const {
  return shape.size() == 4 ? blocked(shape) : plain(shape);
}

bool PlanBuilder::is_blocked(ValueId value) {
  return shape(value).size() == 4 && located(value).layout == blocked(shape(value));
}

memory PlanBuilder::constant_memory(const Layout& layout, const std::vector<float>& data) const {
  const memory result(layout, plan_->engine);
  // A constant may hold no numbers, and then has no address.
  if (!data.empty()) {
    std::memcpy(result.get_data_handle(), data.data(), data.size() * sizeof(float));
  }
  return result;
}

memory PlanBuilder::reordered(memory from, const Layout& layout,
                              const dnnl::primitive_attr& attributes) {
  memory to(layout, plan_->engine);
  dnnl::reorder(from, to, attributes).execute(stream_, from, to);
  stream_.wait();
  return to;
}

TensorView PlanBuilder::add_constant(memory constant) {
  plan_->constants.push_back(constant);
  return {{true, plan_->constants.size() - 1, 0}, constant.get_desc()};
}

TensorView PlanBuilder::located(ValueId value) {
  if (!located_[value]) {
    const Value& known = program_.values[value];
    located_[value] = add_constant(constant_memory(plain(known.shape), known.constant->floats));
  }
  return *located_[value];
}

TensorView PlanBuilder::in_layout(ValueId value, const Layout& layout) {
  const TensorView present = located(value);
  if (present.layout == layout) return present;
  for (const TensorView& further : reordered_[value]) {
    if (further.layout == layout) return further;
  }
  TensorView result;
  if (present.place.is_constant) {
    result = add_constant(reordered(plan_->constants[present.place.index], layout));
  } else {
    result = new_buffer(layout);
    copy(present, result, scale_between(value, present.layout, layout));
  }
  reordered_[value].push_back(result);
  return result;
}

TensorView PlanBuilder::in_floats(ValueId value) {
  const TensorView present = located(value);
  return present.layout.data_type() == memory::data_type::f32
             ? present
             : in_layout(value, usual(shape(value)));
}

float PlanBuilder::scale_between(ValueId value, const Layout& from, const Layout& to) const {
  const bool from_floats = from.data_type() == memory::data_type::f32;
  if (from_floats == (to.data_type() == memory::data_type::f32)) return 1;
  const float step = program_.values[value].eight_bits->step;
  return from_floats ? 1 / step : step;
}

TensorView PlanBuilder::new_buffer(const Layout& layout) {
  buffers_.push_back({layout.get_size(), static_cast<std::size_t>(-1), 0});
  return {{false, buffers_.size() - 1, 0}, layout};
}

TensorView PlanBuilder::place_output(ValueId value, const Layout& layout) {
  TensorView result;
  if (concats_[value] && layout == usual(shape(value))) {
    const ConcatSlot& slot = *concats_[value];
    result = {place_of_join(slot.target), layout};
    result.place.offset += slot.values_before * sizeof(float);
  } else {
    result = new_buffer(layout);
  }
  located_[value] = result;
  return result;
}

Place PlanBuilder::place_of_join(ValueId target) {
  std::optional<Place>& place = concat_places_.at(target);
  if (!place) place = place_output(target, usual(shape(target))).place;
  return *place;
}

void PlanBuilder::copy(const TensorView& from, const TensorView& to, float scale) {
  dnnl::primitive_attr attributes;
  if (scale != 1) attributes.set_output_scales(0, {scale});
  const dnnl::reorder::primitive_desc description(plan_->engine, from.layout, plan_->engine,
                                                  to.layout, attributes);
  add_primitive(dnnl::reorder(description), description.scratchpad_desc(),
                {{DNNL_ARG_FROM, from}, {DNNL_ARG_TO, to}});
}

void PlanBuilder::add_primitive(const dnnl::primitive& primitive, const Layout& scratchpad,
                                std::vector<PlannedOp::Operand> operands) {
  if (scratchpad.get_size() > 0) operands.push_back({DNNL_ARG_SCRATCHPAD, new_buffer(scratchpad)});
  plan_->steps.push_back({primitive, nullptr, std::move(operands)});
}

void PlanBuilder::add_kernel(Kernel kernel, std::vector<TensorView> operands) {
  PlannedOp step;
  step.kernel = std::move(kernel);
  for (const TensorView& operand : operands) step.operands.push_back({0, operand});
  plan_->steps.push_back(std::move(step));
}

std::string PlanBuilder::node() const {
  return layer_ < program_.layers.size() ? program_.layers[layer_].node : "";
}

void PlanBuilder::plan_memory_of_steps() {
  const auto needs = [&](const Place& place, std::size_t step) {
    if (place.is_constant) return;
    Buffer& buffer = buffers_[place.index];
    buffer.first = std::min(buffer.first, step);
    buffer.last = std::max(buffer.last, step);
  };
  for (const TensorView& input : plan_->inputs) needs(input.place, 0);
  for (std::size_t i = 0; i < plan_->steps.size(); ++i) {
    for (const PlannedOp::Operand& operand : plan_->steps[i].operands)
      needs(operand.value.place, i);
  }
  for (const TensorView& output : plan_->outputs) needs(output.place, plan_->steps.size());
  plan_->memory = plan_memory(buffers_);
}

Expected<std::shared_ptr<const Plan>> make_plan(const Program& program,
                                                const PlanOptions& options) {
  std::optional<PlanBuilder> builder;
  try {
    builder.emplace(program, options);
    std::shared_ptr<const Plan> plan = builder->build();
    constexpr std::size_t kMaxBytes = std::size_t{1} << 32;
    if (plan->memory.bytes > kMaxBytes) {
      return fail("a run would take {} MB of memory; at most {} are given",
                  plan->memory.bytes >> 20, kMaxBytes >> 20);
    }
    return plan;
  } catch (const dnnl::error& error) {
    return fail("node \"{}\": oneDNN cannot run it: {}", builder ? builder->node() : "",
                error.what());
  }
}

}  // namespace roomwise::network
