// What fine-tuning costs: steps on random pictures, on the given number of threads:
//   training_benchmark [THREADS]
// MobileNetV2 of ROOMWISE_MODELS and Inception-v3 with its second head, all layers and the last
// block alone, at several sizes of batches.

#include <ATen/Functions.h>
#include <ATen/Parallel.h>
#include <ATen/TensorOperators.h>
#include <fmt/format.h>

#include <chrono>
#include <cstdlib>
#include <ctime>

#include "arguments.h"
#include "laboratory/training/head.h"
#include "laboratory/training/loss.h"
#include "laboratory/training/training_state.h"
#include "roomwise/network/formats/network_file.h"
#include "roomwise/network/graph/inception_v3.h"
#include "timing.h"

extern "C" void openblas_set_num_threads(int count);

namespace {

using namespace roomwise;
using namespace roomwise::network;
using namespace roomwise::training;
using bench::need;

constexpr std::size_t kClasses = 10;
constexpr int kSteps = 2;  // timed, after as many that are not

struct Subject {
  std::string name;
  OnnxGraph graph;
  std::string features;
  std::string last_block;
};

void measure(const Subject& subject, const std::string& from, std::int64_t batch) {
  const NewHead head = need(with_new_head(subject.graph, subject.features, kClasses, 1));
  TrainableGraphOptions of_graph{head.graph.outputs, from, at::kCPU};
  const TrainableGraph graph = need(TrainableGraph::create(head.graph, of_graph));
  const TrainingOptions options;
  TrainingState state = begin_training(graph, options);
  const Shape& shape = subject.graph.inputs.front().shape;
  const at::Tensor pictures = at::rand({batch, 3, shape[2], shape[3]}) * 2 - 1;
  const at::Tensor labels = at::arange(batch, at::kLong).remainder(std::int64_t{kClasses});
  const auto step = [&] {
    const at::Tensor loss = loss_of(need(graph.forward(pictures, true)), labels, options);
    loss.backward();
    descend(state, 0.001);
  };
  for (int i = 0; i < kSteps; ++i) step();  // until memory grows no more
  const std::clock_t cpu = std::clock();
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < kSteps; ++i) step();
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  const double cpu_ms = 1000.0 * static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
  const auto count = static_cast<double>(kSteps * batch);
  fmt::print("{:<14} {:<12} batch {:>2}: {:>6.0f} CPU-ms a picture, {:>5.1f} pictures a second\n",
             subject.name, from.empty() ? "all layers" : from, batch, cpu_ms / count,
             count / wall.count());
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const auto threads = bench::only_count(argc, argv, 1, "training_benchmark [THREADS]");
  if (!threads) {
    fmt::print(stderr, "{}\n", threads.error().message);
    return 2;
  }
  keep_memory_of_large_tensors();
  at::set_num_threads(*threads);
  openblas_set_num_threads(*threads);
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
      for (const std::int64_t batch : {8, 16, 32}) measure(subject, from, batch);
    }
  }
  return 0;
}
