#include "roomwise/network/executor/executor.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <map>
#include <mutex>

#include "roomwise/base/thread_pool.h"
#include "roomwise/network/executor/plan.h"
#include "roomwise/network/executor/quantization.h"
#include "roomwise/network/graph/lowering.h"

namespace roomwise::network {
namespace {

// A plan and the runs of it that nobody is in.
struct SharedPlan {
  std::shared_ptr<const Plan> plan;
  std::mutex mutex;
  std::vector<std::unique_ptr<PlanRun>> idle;

  std::unique_ptr<PlanRun> take() {
    {
      const std::scoped_lock lock(mutex);
      if (!idle.empty()) {
        auto run = std::move(idle.back());
        idle.pop_back();
        return run;
      }
    }
    return std::make_unique<PlanRun>(plan);
  }
  void put_back(std::unique_ptr<PlanRun> run) {
    const std::scoped_lock lock(mutex);
    idle.push_back(std::move(run));
  }
};

bool has_free_size(const GraphInput& input) {
  return input.shape.empty() || std::ranges::count(input.shape, GraphInput::kDynamic) > 0;
}

Expected<void> check_input(const Tensor& tensor, const GraphInput& input) {
  const auto fits = [](std::int64_t given, std::int64_t wanted) {
    return given >= 0 && (wanted == GraphInput::kDynamic || given == wanted);
  };
  if (!input.shape.empty() && !std::ranges::equal(tensor.shape, input.shape, fits)) {
    return fail("the input \"{}\" takes {}, not {}", input.name, shape_text(input.shape),
                shape_text(tensor.shape));
  }
  ROOMWISE_RETURN_IF_ERROR(check_size(tensor.shape));
  if (tensor.values.size() != element_count(tensor.shape)) {
    return fail("the input \"{}\" has {} values for the shape {}", input.name, tensor.values.size(),
                shape_text(tensor.shape));
  }
  return {};
}

// In 8 bits a mean costs little, and would round what the convolution adds up.
PassOptions passes_of(const ExecutorOptions& options, bool in_eight_bits) {
  PassOptions passes = options.passes;
  if (in_eight_bits) passes.swaps_means = false;
  return passes;
}

Expected<Program> program_for(const OnnxGraph& graph, std::span<const Shape> shapes,
                              const std::vector<std::string>& outputs, const PassOptions& passes) {
  ROOMWISE_TRY(Program program, lower(graph, shapes, outputs, passes.folds_constants));
  return run_passes(std::move(program), passes);
}

// What the work gives; what oneDNN or a lack of memory throws is an error too.
template <typename Value, typename Work>
Expected<Value> guarded(const Work& work) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return fail("there is not enough memory to run the network on inputs of this size");
  } catch (const dnnl::error& error) {
    return fail("oneDNN cannot run the network: {}", error.what());
  }
}

}  // namespace

class Executor::Implementation {
 public:
  Implementation(OnnxGraph graph, ExecutorOptions options)
      : inputs_(graph.inputs), graph_(std::move(graph)), options_(std::move(options)) {}

  // Where all sizes are known there is one plan, and the weights as the file has them may go.
  Expected<void> plan_fixed_sizes() {
    if (std::ranges::any_of(inputs_, has_free_size)) return {};
    std::vector<Shape> shapes;
    for (const GraphInput& input : inputs_) shapes.push_back(input.shape);
    ROOMWISE_RETURN_IF_ERROR(plan_for(shapes));
    graph_ = {};
    options_.eight_bits.reset();
    return {};
  }

  [[nodiscard]] const std::vector<GraphInput>& inputs() const { return inputs_; }

  Expected<std::vector<Tensor>> run(std::span<const Tensor> inputs) {
    return guarded<std::vector<Tensor>>([&] { return run_unguarded(inputs); });
  }

 private:
  using SharedPlanPointer = std::shared_ptr<SharedPlan>;

  Expected<std::vector<Tensor>> run_unguarded(std::span<const Tensor> inputs) {
    if (inputs.size() != inputs_.size()) {
      return fail("the network has {} inputs, not {}", inputs_.size(), inputs.size());
    }
    std::vector<Shape> shapes;
    std::vector<std::span<const float>> values;
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      ROOMWISE_RETURN_IF_ERROR(check_input(inputs[i], inputs_[i]));
      shapes.push_back(inputs[i].shape);
      values.emplace_back(inputs[i].values);
    }
    ROOMWISE_TRY(const SharedPlanPointer shared, plan_for(shapes));
    auto run = shared->take();
    auto ran = run->run(values);
    shared->put_back(std::move(run));
    ROOMWISE_TRY(std::vector<std::vector<float>> results, std::move(ran));
    std::vector<Tensor> outputs;
    for (std::size_t i = 0; i < results.size(); ++i)
      outputs.push_back({shared->plan->output_shapes[i], std::move(results[i])});
    return outputs;
  }

  // Made by the first that asks; who asks meanwhile waits for it, but not for other sizes. One that
  // fails is not kept: sizes that do not fit must not fill the memory.
  Expected<SharedPlanPointer> plan_for(const std::vector<Shape>& shapes) {
    std::promise<Expected<SharedPlanPointer>> promise;
    std::shared_future<Expected<SharedPlanPointer>> planned;
    bool is_first = false;
    {
      const std::scoped_lock lock(mutex_);
      const auto [entry, is_new] = plans_.try_emplace(shapes);
      if (is_new) entry->second = promise.get_future().share();
      planned = entry->second;
      is_first = is_new;
    }
    if (is_first) {
      Expected<SharedPlanPointer> made =
          guarded<SharedPlanPointer>([&] { return new_plan(shapes); });
      if (!made) {
        const std::scoped_lock lock(mutex_);
        plans_.erase(shapes);
      }
      promise.set_value(std::move(made));
    }
    return planned.get();
  }

  [[nodiscard]] Expected<SharedPlanPointer> new_plan(const std::vector<Shape>& shapes) const {
    const PassOptions passes = passes_of(options_, options_.eight_bits.has_value());
    ROOMWISE_TRY(Program program, program_for(graph_, shapes, options_.outputs, passes));
    if (options_.eight_bits) {
      ROOMWISE_TRY(const auto ranges, ranges_of_values(program, *options_.eight_bits));
      quantize(program, ranges, options_.eight_bits->min_channels);
    }
    auto shared = std::make_shared<SharedPlan>();
    ROOMWISE_TRY(shared->plan, make_plan(program, {passes.concat_in_place, passes.uses_winograd,
                                                   options_.threads_per_input}));
    return shared;
  }

  std::vector<GraphInput> inputs_;
  OnnxGraph graph_;
  ExecutorOptions options_;
  std::mutex mutex_;
  std::map<std::vector<Shape>, std::shared_future<Expected<SharedPlanPointer>>> plans_;
};

Executor::Executor(std::unique_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}
Executor::~Executor() = default;

Expected<std::unique_ptr<Executor>> Executor::create(OnnxGraph graph, ExecutorOptions options) {
  constexpr std::size_t kMaxThreads = 64;
  if (options.threads_per_input < 1 || options.threads_per_input > kMaxThreads) {
    return fail("{} threads cannot share the work on an input; 1 to {} can",
                options.threads_per_input, kMaxThreads);
  }
  auto implementation = std::make_unique<Implementation>(std::move(graph), std::move(options));
  ROOMWISE_RETURN_IF_ERROR(implementation->plan_fixed_sizes());
  return std::unique_ptr<Executor>(new Executor(std::move(implementation)));
}

const std::vector<GraphInput>& Executor::inputs() const {
  return implementation_->inputs();
}

Expected<std::vector<Tensor>> Executor::run(std::span<const Tensor> inputs) const {
  return implementation_->run(inputs);
}

Expected<std::vector<std::vector<Tensor>>> Executor::run_batch(std::span<const Tensor> batch,
                                                               std::size_t threads) const {
  std::vector<Expected<std::vector<Tensor>>> results(batch.size());
  const auto run_one = [&](std::size_t i) { results[i] = run(batch.subspan(i, 1)); };
  if (threads <= 1 || batch.size() <= 1) {
    for (std::size_t i = 0; i < batch.size(); ++i) run_one(i);
  } else {
    ThreadPool(std::min(threads, batch.size())).parallel_for(batch.size(), run_one);
  }
  std::vector<std::vector<Tensor>> outputs;
  for (auto& result : results) {
    ROOMWISE_TRY(std::vector<Tensor> output, std::move(result));
    outputs.push_back(std::move(output));
  }
  return outputs;
}

Expected<EightBitRanges> calibrate_eight_bits(const OnnxGraph& graph,
                                              const ExecutorOptions& options,
                                              std::span<const Tensor> inputs) {
  if (inputs.empty()) return fail("8 bits need inputs to measure on");
  return guarded<EightBitRanges>([&]() -> Expected<EightBitRanges> {
    EightBitRanges measured{.input = inputs.front().shape};
    ROOMWISE_TRY(const Program program, program_for(graph, {&measured.input, 1}, options.outputs,
                                                    passes_of(options, true)));
    ROOMWISE_TRY(const auto ranges, calibrate_ranges(program, inputs));
    measured.of_layers = named_ranges(program, ranges);
    for (const auto& [layer, range] : measured.of_layers) {
      if (!std::isfinite(range.least) || !std::isfinite(range.most))
        return fail("layer \"{}\" gives numbers that are not finite: no 8 bits for it", layer);
    }
    return measured;
  });
}

}  // namespace roomwise::network
