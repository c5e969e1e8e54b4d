#include "laboratory/training/trainer.h"

#include <ATen/Context.h>
#include <ATen/Functions.h>
#include <ATen/Parallel.h>
#include <ATen/core/grad_mode.h>
#include <malloc.h>
#include <torch/version.h>

#include <cmath>

#include "laboratory/training/batch_loader.h"
#include "laboratory/training/head.h"
#include "laboratory/training/loss.h"
#include "laboratory/training/processes.h"
#include "laboratory/training/training_state.h"
#include "roomwise/network/formats/onnx_writer.h"

#ifdef ROOMWISE_OPENBLAS
extern "C" void openblas_set_num_threads(int count);
#endif

namespace roomwise::training {
namespace {

// Streams of random numbers that batch_loader.cpp does not draw from.
constexpr std::uint64_t kDropout = 3;

bool is_better(const CurvePoint& point, const std::optional<CurvePoint>& best) {
  if (!best || std::isnan(point.held_out_precision)) return true;
  if (point.held_out_precision != best->held_out_precision)
    return point.held_out_precision > best->held_out_precision;
  return point.held_out_cross_entropy < best->held_out_cross_entropy;
}

// How many pictures, and a digest of what they are called and of their classes.
std::string described(const TrainingData& data) {
  std::string names;
  for (std::size_t i = 0; i < data.size(); ++i)
    names += fmt::format("{} {}\n", data.label(i), data.name(i));
  return fmt::format("{} {}", data.size(), sha256_hex(Bytes(names.begin(), names.end())));
}

class Training {
 public:
  Training(const TrainingTask& task, const TrainingOptions& options, Processes& processes,
           Progress& progress)
      : task_(task), options_(options), processes_(processes), progress_(progress) {}

  Expected<TrainingResult> run() {
    ROOMWISE_RETURN_IF_ERROR(begin());
    BatchLoaderOptions loading;
    loading.batch = options_.batch;
    loading.rank = processes_.rank();
    loading.processes = processes_.count();
    loading.seed = options_.seed;
    loading.augmentation = options_.augmentation;
    loading.threads = options_.loader_threads;
    BatchLoader loader(*task_.training, task_.card, loading, state_.step);
    progress_.begin("training", static_cast<std::uint64_t>(options_.steps));
    bool interrupted = false;
    while (state_.step < options_.steps && !interrupted) {
      ROOMWISE_TRY(interrupted, make_step(loader));
      const bool last = state_.step == options_.steps;
      if (last || state_.step % options_.evaluate_every == 0) ROOMWISE_RETURN_IF_ERROR(evaluate());
      if (interrupted || last || state_.step % options_.checkpoint_every == 0)
        ROOMWISE_RETURN_IF_ERROR(write_checkpoint());
      progress_.advance(static_cast<std::uint64_t>(state_.step), note());
    }
    progress_.end();
    return result(state_.step < options_.steps);
  }

 private:
  Expected<void> begin() {
    ROOMWISE_RETURN_IF_ERROR(options_.validate());
    if (task_.training == nullptr || task_.training->size() == 0)
      return fail("there are no pictures to train on");
    ROOMWISE_TRY(const bool on_gpu, use_gpu(options_.device));
    device_ = on_gpu ? at::kCUDA : at::kCPU;
    set_threads(options_.threads);
    at::globalContext().setBenchmarkCuDNN(false);
    at::globalContext().setDeterministicCuDNN(true);
    TrainableGraphOptions of_graph{{task_.logits}, options_.from, device_};
    if (!task_.aux_logits.empty()) of_graph.outputs.push_back(task_.aux_logits);
    ROOMWISE_TRY(graph_, TrainableGraph::create(task_.graph, of_graph));
    state_ = begin_training(*graph_, options_);
    if (state_.tensors.empty()) return fail("no layer is trained; train from an earlier one");
    ROOMWISE_TRY(const std::string what, description());
    ROOMWISE_RETURN_IF_ERROR(check_same_as_others(what));
    fingerprint_ = fmt::format("{}threads {}\n", what, options_.threads);
    if (options_.resume) ROOMWISE_RETURN_IF_ERROR(read_checkpoint());
    return {};
  }

  // What the training is, alike in all processes: options, weights, data.
  Expected<std::string> description() const {
    ROOMWISE_TRY(const Bytes onnx, network::write_onnx_graph(task_.graph));
    const network::ModelCard& card = task_.card;
    return fmt::format(
        "{}processes {}\nclasses {}\npictures {}\nheld out {}\n"
        "input {} x {} colors {} fit {} mean {} scale {}\nnetwork {}\n",
        options_.fingerprint(), processes_.count(), fmt::join(task_.training->classes(), ", "),
        described(*task_.training), task_.held_out == nullptr ? "0" : described(*task_.held_out),
        card.input_width_px, card.input_height_px, static_cast<int>(card.color_order),
        static_cast<int>(card.fit), fmt::join(card.mean, " "), fmt::join(card.scale, " "),
        sha256_hex(onnx));
  }

  // Processes that train different things would average what does not belong together.
  Expected<void> check_same_as_others(const std::string& what) {
    const std::string mine = fmt::format("{}resume {}\n", what, options_.resume);
    ROOMWISE_TRY(const Bytes told, processes_.broadcast(Bytes(mine.begin(), mine.end())));
    const std::string first(told.begin(), told.end());
    if (first == mine) return {};
    return fail(
        "the process of rank 0 trains otherwise than this one of rank {}: {}; give all of them the "
        "same options, network and pictures",
        processes_.rank(), first_difference(first, mine));
  }

  // Gives whether any of the processes was interrupted.
  Expected<bool> make_step(BatchLoader& loader) {
    ROOMWISE_TRY(Batch pictures, loader.next());
    const TensorBatch batch = tensors_of(pictures.pictures, pictures.labels, task_.card, device_);
    RandomStream random(options_.seed, {kDropout, static_cast<std::uint64_t>(state_.step),
                                        static_cast<std::uint64_t>(processes_.rank())});
    at::manual_seed(random.next());
    ROOMWISE_TRY(const Values outputs, graph_->forward(batch.pictures, true));
    ROOMWISE_RETURN_IF_ERROR(check_outputs(outputs));
    const at::Tensor loss = loss_of(outputs, batch.labels, options_);
    loss.backward();
    const at::Tensor told =
        at::tensor({loss.item<float>(), progress_.interrupted() ? 1.0F : 0.0F}, at::kFloat)
            .to(device_);
    ROOMWISE_RETURN_IF_ERROR(average_with_others(told));
    const double entropy = told[0].item<double>();
    if (!std::isfinite(entropy)) {
      return fail("the cross-entropy is no number any more at step {}; try a lower learning rate",
                  state_.step + 1);
    }
    descend(state_, options_.rate.at(state_.step, options_.steps));
    state_.loss_sum += entropy;
    ++state_.step;
    return told[1].item<double>() > 0;
  }

  Expected<void> check_outputs(const Values& outputs) const {
    const auto classes = static_cast<std::int64_t>(task_.training->classes().size());
    for (const at::Tensor& output : outputs) {
      const at::Tensor scores = output.flatten(1);
      if (scores.size(0) == options_.batch && scores.size(1) == classes) continue;
      return fail("the network gives {} x {} scores for {} pictures of {} classes", scores.size(0),
                  scores.size(1), options_.batch, classes);
    }
    return {};
  }

  Expected<void> average_with_others(const at::Tensor& told) {
    std::vector<at::Tensor> shared{told};
    for (const GraphTensor& parameter : graph_->parameters()) {
      // One that no output hangs on has none, in any process.
      const at::Tensor& gradient = parameter.tensor.grad();
      if (parameter.trained && gradient.defined()) shared.push_back(gradient);
    }
    for (const GraphTensor& statistic : graph_->statistics()) {
      if (statistic.trained) shared.push_back(statistic.tensor);
    }
    return processes_.average(shared);
  }

  Expected<void> evaluate() {
    ROOMWISE_TRY(const HeldOutScore score,
                 score_held_out(*graph_, task_, options_, device_, processes_));
    const std::int64_t since = state_.curve.empty() ? 0 : state_.curve.back().step;
    const CurvePoint point{state_.step, state_.loss_sum / static_cast<double>(state_.step - since),
                           score.cross_entropy, score.precision};
    state_.loss_sum = 0;
    state_.curve.push_back(point);
    if (!is_better(point, state_.best)) return {};
    state_.best = point;
    state_.best_tensors.clear();
    for (const at::Tensor& tensor : state_.tensors)
      state_.best_tensors.push_back(tensor.detach().clone());
    return {};
  }

  Expected<void> write_checkpoint() {
    if (options_.checkpoint.empty() || processes_.rank() != 0) return {};
    ROOMWISE_TRY(const Bytes bytes, state_.write(fingerprint_));
    return write_file(options_.checkpoint, bytes);
  }

  Expected<void> read_checkpoint() {
    Bytes bytes;
    if (processes_.rank() == 0) {
      ROOMWISE_TRY(bytes, read_file(options_.checkpoint));
    }
    ROOMWISE_TRY(bytes, processes_.broadcast(std::move(bytes)));
    return state_.read(bytes, fingerprint_).map_error([&](Error error) {
      return std::move(error).with_context(options_.checkpoint.string());
    });
  }

  [[nodiscard]] std::string note() const {
    if (state_.curve.empty()) return "";
    const CurvePoint& point = state_.curve.back();
    std::string text = fmt::format("cross-entropy {:.3f}", point.cross_entropy);
    if (!std::isnan(point.held_out_precision))
      text += fmt::format(", held-out precision {:.3f}", point.held_out_precision);
    return text;
  }

  // The best weights so far, or, before the first evaluation, the present ones.
  TrainingResult result(bool interrupted) {
    const at::NoGradGuard no_gradient;
    for (std::size_t i = 0; i < state_.best_tensors.size(); ++i)
      state_.tensors[i].copy_(state_.best_tensors[i]);
    TrainingResult result;
    result.graph = reduced_to(graph_->graph(), task_.logits);
    result.curve = state_.curve;
    result.best_step = state_.best ? state_.best->step : state_.step;
    result.steps = state_.step;
    result.finished = !interrupted;
    return result;
  }

  const TrainingTask& task_;
  const TrainingOptions& options_;
  Processes& processes_;
  Progress& progress_;
  at::Device device_ = at::kCPU;
  std::optional<TrainableGraph> graph_;
  TrainingState state_;
  std::string fingerprint_;
};

}  // namespace

Expected<TrainingResult> train(const TrainingTask& task, const TrainingOptions& options,
                               Processes& processes, Progress& progress) {
  try {
    return Training(task, options, processes, progress).run();
  } catch (const std::exception& error) {  // libtorch's, or no memory
    return fail("the training failed: {}", first_line(error));
  }
}

void set_threads(int count) {
  at::set_num_threads(count);
#ifdef ROOMWISE_OPENBLAS
  openblas_set_num_threads(count);
#endif
}

void keep_memory_of_large_tensors() {
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, -1);
}

Expected<bool> use_gpu(Device device) {
  const bool has_gpu = at::hasCUDA();
  if (device == Device::kCuda && !has_gpu) {
    return fail(
        "there is no GPU that this libtorch ({}) can use: it was built without CUDA, or the "
        "machine has none; give --device cpu",
        TORCH_VERSION);
  }
  return device != Device::kCpu && has_gpu;
}

}  // namespace roomwise::training
