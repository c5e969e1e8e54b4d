#include "roomwise/network/executor/plan.h"

#include <omp.h>

#include <algorithm>
#include <cstring>
#include <new>

namespace roomwise::network {

ScopedOmpThreads::ScopedOmpThreads(std::size_t count) : before_(omp_get_max_threads()) {
  omp_set_num_threads(static_cast<int>(count));
}
ScopedOmpThreads::~ScopedOmpThreads() {
  omp_set_num_threads(before_);
}

PlanRun::PlanRun(std::shared_ptr<const Plan> plan)
    : plan_(std::move(plan)), stream_(plan_->engine) {
  constexpr std::size_t kAlignment = 64;
  const std::size_t bytes = std::max(plan_->memory.bytes, kAlignment);
  memory_.reset(static_cast<std::byte*>(std::aligned_alloc(kAlignment, bytes)));
  if (memory_ == nullptr) throw std::bad_alloc();
  for (const PlannedOp& step : plan_->steps) {
    auto& arguments = arguments_.emplace_back();
    if (step.kernel) continue;
    for (const PlannedOp::Operand& operand : step.operands) {
      arguments.insert({operand.argument, dnnl::memory(operand.value.layout, plan_->engine,
                                                       data(operand.value.place))});
    }
  }
}

float* PlanRun::data(const Place& place) const {
  std::byte* begin = place.is_constant
                         ? static_cast<std::byte*>(plan_->constants[place.index].get_data_handle())
                         : memory_.get() + plan_->memory.offsets[place.index];
  return reinterpret_cast<float*>(begin + place.offset);
}

std::vector<float> PlanRun::read(const TensorView& value) const {
  const float* begin = data(value.place);
  return {begin, begin + value.layout.get_size() / sizeof(float)};
}

Expected<std::vector<std::vector<float>>> PlanRun::run(
    std::span<const std::span<const float>> inputs) {
  const ScopedOmpThreads threads(plan_->threads);
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    std::memcpy(data(plan_->inputs[i].place), inputs[i].data(), inputs[i].size_bytes());
  }
  std::vector<const float*> sources;
  for (std::size_t i = 0; i < plan_->steps.size(); ++i) {
    const PlannedOp& step = plan_->steps[i];
    if (!step.kernel) {
      step.primitive.execute(stream_, arguments_[i]);
      continue;
    }
    sources.clear();
    for (const PlannedOp::Operand& operand : step.operands)
      sources.push_back(data(operand.value.place));
    ROOMWISE_RETURN_IF_ERROR(step.kernel(std::span(sources).first(sources.size() - 1),
                                         data(step.operands.back().value.place)));
  }
  stream_.wait();
  std::vector<std::vector<float>> outputs;
  for (const TensorView& output : plan_->outputs) outputs.push_back(read(output));
  return outputs;
}

}  // namespace roomwise::network
