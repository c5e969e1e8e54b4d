// What fine-tuning costs: steps on random pictures, on the given number of threads or on a GPU:
//   training_benchmark [THREADS] [cpu|cuda]
// MobileNetV2 of ROOMWISE_MODELS and Inception-v3 with its second head, all layers and the last
// block alone, at several sizes of batches; and looking at two pictures, as a room is asked for.

#include <ATen/Functions.h>
#include <ATen/TensorOperators.h>
#include <ATen/core/grad_mode.h>
#include <fmt/format.h>

#include <chrono>
#include <cstdlib>
#include <ctime>

#include "arguments.h"
#include "laboratory/training/head.h"
#include "laboratory/training/loss.h"
#include "laboratory/training/trainer.h"
#include "laboratory/training/training_state.h"
#include "roomwise/network/formats/network_file.h"
#include "roomwise/network/graph/inception_v3.h"
#include "timing.h"

namespace {

using namespace roomwise;
using namespace roomwise::network;
using namespace roomwise::training;
using bench::need;

constexpr std::size_t kClasses = 10;
struct Subject {
  std::string name;
  OnnxGraph graph;
  std::string features;
  std::string last_block;
};

struct Time {
  double cpu_ms = 0, wall_ms = 0;
};

// A call of `work`, on the mean of several, after as many that are not timed: memory grows and a
// GPU's kernels are loaded in the first ones. `work` waits for what it started.
template <typename Work>
Time time_of(at::Device device, const Work& work) {
  const int calls = device.is_cuda() ? 20 : 2;
  for (int i = 0; i < calls; ++i) work();
  const std::clock_t cpu = std::clock();
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < calls; ++i) work();
  const std::chrono::duration<double, std::milli> wall = std::chrono::steady_clock::now() - begin;
  const double cpu_ms = 1000.0 * static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
  return {cpu_ms / calls, wall.count() / calls};
}

at::Tensor random_pictures(const Subject& subject, std::int64_t batch, at::Device device) {
  const Shape& shape = subject.graph.inputs.front().shape;
  return (at::rand({batch, 3, shape[2], shape[3]}) * 2 - 1).to(device);
}

void measure_step(const Subject& subject, const std::string& from, std::int64_t batch,
                  at::Device device) {
  const NewHead head = need(with_new_head(subject.graph, subject.features, kClasses, 1));
  TrainableGraphOptions of_graph{head.graph.outputs, from, device};
  const TrainableGraph graph = need(TrainableGraph::create(head.graph, of_graph));
  const TrainingOptions options;
  TrainingState state = begin_training(graph, options);
  const at::Tensor pictures = random_pictures(subject, batch, device);
  const at::Tensor labels =
      at::arange(batch, at::kLong).remainder(std::int64_t{kClasses}).to(device);
  const Time time = time_of(device, [&] {
    const at::Tensor loss = loss_of(need(graph.forward(pictures, true)), labels, options);
    loss.backward();
    descend(state, 0.001);
    (void)loss.item<float>();
  });
  const auto count = static_cast<double>(batch);
  fmt::print("{:<14} {:<12} batch {:>3}: {:>6.1f} CPU-ms a picture, {:>7.1f} pictures a second\n",
             subject.name, from.empty() ? "all layers" : from, batch, time.cpu_ms / count,
             1000 * count / time.wall_ms);
  std::fflush(stdout);
}

void measure_look(const Subject& subject, at::Device device) {
  const at::NoGradGuard no_gradient;
  TrainableGraphOptions of_graph{{}, {}, device};
  const TrainableGraph graph = need(TrainableGraph::create(subject.graph, of_graph));
  const at::Tensor pictures = random_pictures(subject, 2, at::kCPU);
  const Time time = time_of(device, [&] {  // with the way to the GPU and back
    (void)need(graph.forward(pictures.to(device), false)).front().cpu();
  });
  fmt::print("{:<14} features of two pictures: {:.2f} ms\n", subject.name, time.wall_ms);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const bool on_gpu = argc == 3 && std::string_view(argv[2]) == "cuda";
  const bool says_device = on_gpu || (argc == 3 && std::string_view(argv[2]) == "cpu");
  const auto threads =
      bench::only_count(says_device ? 2 : argc, argv, 1, "training_benchmark [THREADS] [cpu|cuda]");
  if (!threads) {
    fmt::print(stderr, "{}\n", threads.error().message);
    return 2;
  }
  const at::Device device =
      need(use_gpu(on_gpu ? Device::kCuda : Device::kCpu)) ? at::kCUDA : at::kCPU;
  keep_memory_of_large_tensors();
  set_threads(*threads);
  const char* models = std::getenv("ROOMWISE_MODELS");
  if (models == nullptr) {
    fmt::print(stderr, "set ROOMWISE_MODELS to the folder of networks\n");
    return 1;
  }
  const std::filesystem::path mobilenet =
      std::filesystem::path(models) / "mobilenet-v2-imagenet.onnx";
  InceptionOptions inception;
  inception.has_auxiliary_head = true;
  const Subject subjects[] = {
      {"MobileNetV2", need(read_network_file(mobilenet, std::nullopt)).graph,
       "GlobalAveragePool_129", "Conv_121"},
      {"Inception-v3", inception_v3(inception), "features", "Mixed_7c"}};
  for (const Subject& subject : subjects) {
    for (const std::string& from : {std::string(), subject.last_block}) {
      for (const std::int64_t batch : {8, 16, 32}) measure_step(subject, from, batch, device);
      if (on_gpu) measure_step(subject, from, 128, device);
    }
    measure_look(subject, device);
  }
  return 0;
}
