#pragma once

#include <memory>
#include <oneapi/dnnl/dnnl.hpp>
#include <unordered_map>
#include <vector>

#include "roomwise/network/executor/memory_plan.h"
#include "roomwise/network/executor/plain_kernels.h"
#include "roomwise/network/graph/passes.h"
#include "roomwise/network/graph/program.h"

namespace roomwise::network {

// Where a value lies: in the memory of a run, or among what all runs share (weights, constants).
struct Place {
  bool is_constant = false;
  std::size_t index = 0;   // of the buffer or the constant
  std::size_t offset = 0;  // bytes within it
  bool operator==(const Place&) const = default;
};

// A value in one layout.
struct TensorView {
  Place place;
  dnnl::memory::desc layout;
};

// One call: of a oneDNN primitive, or of a kernel of our own (reads operands in their order, writes
// the last).
struct PlannedOp {
  struct Operand {
    int argument = 0;  // of the primitive
    TensorView value;
  };
  dnnl::primitive primitive;
  Kernel kernel;  // empty: the primitive
  std::vector<Operand> operands;
};

// How a program is run by oneDNN on so many threads, in layouts of its choosing: primitives made,
// weights packed, memory laid out. Made once and shared by all runs; it does not change.
struct Plan {
  dnnl::engine engine{dnnl::engine::kind::cpu, 0};
  std::vector<PlannedOp> steps;
  std::vector<dnnl::memory> constants;
  MemoryPlan memory;
  std::vector<TensorView> inputs;   // row by row
  std::vector<TensorView> outputs;  // row by row
  std::vector<Shape> output_shapes;
  std::size_t threads = 1;
};

struct PlanOptions {
  bool concat_in_place = true;  // what is joined is written where it is wanted
  bool uses_winograd = true;    // for 3x3 convolutions, where that is faster
  std::size_t threads = 1;      // that share the work of one picture
};

// Fails where oneDNN refuses a layer, naming its node.
[[nodiscard]] Expected<std::shared_ptr<const Plan>> make_plan(const Program& program,
                                                              const PlanOptions& options);

// The memory of one run at a time of a plan.
class PlanRun {
 public:
  explicit PlanRun(std::shared_ptr<const Plan> plan);

  // inputs: one each, of the plan's sizes. Works on the calling thread, and on others of OpenMP
  // where the plan is for several. Fails where a layer cannot work on what the inputs hold.
  [[nodiscard]] Expected<std::vector<std::vector<float>>> run(
      std::span<const std::span<const float>> inputs);

  [[nodiscard]] std::size_t bytes() const { return plan_->memory.bytes; }

 private:
  struct Free {
    void operator()(void* memory) const { std::free(memory); }
  };
  [[nodiscard]] float* data(const Place& place) const;
  [[nodiscard]] std::vector<float> read(const TensorView& value) const;

  std::shared_ptr<const Plan> plan_;
  std::unique_ptr<std::byte, Free> memory_;
  dnnl::stream stream_;
  std::vector<std::unordered_map<int, dnnl::memory>> arguments_;  // a step each
};

// While it lives, oneDNN works on so many threads for the calling one. Left alone it would start as
// many as there are processors, besides our own.
class ScopedOmpThreads {
 public:
  explicit ScopedOmpThreads(std::size_t count);
  ~ScopedOmpThreads();
  ScopedOmpThreads(const ScopedOmpThreads&) = delete;
  ScopedOmpThreads& operator=(const ScopedOmpThreads&) = delete;

 private:
  int before_;
};

}  // namespace roomwise::network
