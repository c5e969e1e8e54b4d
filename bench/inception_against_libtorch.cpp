// The whole of Inception-v3 by Roomwise and by libtorch, one picture at a time, on one thread on
// one processor:
//   inception_against_libtorch [ROUNDS]
// libtorch runs it as it is, and traced, frozen and optimised for inference. The weights are
// random, which costs no less. A round times each way in turn, so that a busy machine is unfair to
// none.

#include <ATen/Functions.h>
#include <ATen/Parallel.h>
#include <ATen/core/grad_mode.h>
#include <fmt/format.h>
#include <sched.h>
#include <torch/csrc/jit/api/module.h>
#include <torch/csrc/jit/frontend/tracer.h>
#include <torch/version.h>

#include <algorithm>
#include <cstdlib>
#include <functional>

#include "arguments.h"
#include "laboratory/training/trainable_graph.h"
#include "roomwise/image/codec.h"
#include "roomwise/network/executor/executor.h"
#include "roomwise/network/graph/inception_v3.h"
#include "roomwise/network/vision/picture_input.h"
#include "timing.h"

extern "C" void openblas_set_num_threads(int count);

namespace {

using namespace roomwise;
using namespace roomwise::network;
using roomwise::training::TrainableGraph;
namespace fs = std::filesystem;
using bench::need;

constexpr std::size_t kPhotos = 10;
constexpr double kMinCpu_ms = 500;  // that one timing takes

// CPU-ms of one call.
double time_of(const std::function<void()>& call) {
  return bench::cpu_ms_of(call, kMinCpu_ms);
}

std::string text_of(std::vector<double> values) {
  std::ranges::sort(values);
  return fmt::format("{:.2f} ({:.2f} to {:.2f})", values[values.size() / 2], values.front(),
                     values.back());
}

at::Tensor tensor_of(const Tensor& input) {
  return training::tensor_of(Constant{input.shape, false, input.values, {}});
}

// As torch.jit.trace, freeze and optimize_for_inference do it in Python.
torch::jit::Module optimised(const TrainableGraph& graph, const at::Tensor& example) {
  torch::jit::Module module("Inception");
  const auto run = [&](torch::jit::Stack inputs) -> torch::jit::Stack {
    return {need(graph.forward(inputs.front().toTensor(), false)).front()};
  };
  const auto no_name = [](const at::Tensor&) { return std::string(); };
  const auto traced = torch::jit::tracer::trace({example}, run, no_name, /*strict=*/true,
                                                /*force_outplace=*/false, &module);
  const c10::QualifiedName name(*module.type()->name(), "forward");
  auto* forward = module._ivalue()->compilation_unit()->create_function(name, traced.first->graph);
  module.type()->addMethod(forward);
  module.eval();
  torch::jit::Module frozen = torch::jit::freeze(module);
  return torch::jit::optimize_for_inference(frozen);
}

double relative_error(const std::vector<float>& values, const std::vector<float>& expected) {
  double largest = 0, difference = values.size() == expected.size() ? 0 : 1e300;
  for (std::size_t i = 0; i < std::min(values.size(), expected.size()); ++i) {
    largest = std::max(largest, std::abs(static_cast<double>(expected[i])));
    difference = std::max(
        difference, std::abs(static_cast<double>(values[i]) - static_cast<double>(expected[i])));
  }
  return difference / largest;
}

std::vector<Tensor> photos() {
  const char* data = std::getenv("ROOMWISE_DATA");
  if (data == nullptr) {
    fmt::print(stderr, "set ROOMWISE_DATA to the folder of real data\n");
    std::exit(1);
  }
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(fs::path(data) / "object_photos"))
    files.push_back(entry.path());
  std::ranges::sort(files);
  files.resize(std::min(files.size(), kPhotos));
  ModelCard card;
  card.input_width_px = card.input_height_px = 299;
  card.mean = {127.5F, 127.5F, 127.5F};
  card.scale = {1 / 127.5F, 1 / 127.5F, 1 / 127.5F};
  std::vector<Tensor> inputs;
  for (const fs::path& file : files)
    inputs.push_back(picture_input(need(image::read_color(file)), card));
  return inputs;
}

}  // namespace

int main(int argc, char** argv) {
  const auto rounds = bench::only_count(argc, argv, 7, "inception_against_libtorch [ROUNDS]");
  if (!rounds) {
    fmt::print(stderr, "{}\n", rounds.error().message);
    return 2;
  }
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(sched_getcpu(), &one);
  sched_setaffinity(0, sizeof one, &one);
  at::set_num_threads(1);
  openblas_set_num_threads(1);
  const at::NoGradGuard no_gradient;

  const std::vector<Tensor> inputs = photos();
  const OnnxGraph graph = inception_v3();
  const auto executor = need(Executor::create(graph));
  const TrainableGraph plain = need(TrainableGraph::create(graph, {.outputs = {}, .from = "fc"}));
  for (const auto& parameter : plain.parameters()) parameter.tensor.requires_grad_(false);
  torch::jit::Module fast = optimised(plain, tensor_of(inputs.front()));

  double error = 0, error_of_optimised = 0;
  for (const Tensor& input : inputs) {
    const at::Tensor picture = tensor_of(input);
    const auto expected = training::constant_of(need(plain.forward(picture, false)).front()).floats;
    const auto ours = need(executor->run({&input, 1})).front().values;
    error = std::max(error, relative_error(ours, expected));
    const at::Tensor theirs = fast.forward({picture}).toTensor();
    error_of_optimised = std::max(error_of_optimised,
                                  relative_error(training::constant_of(theirs).floats, expected));
  }
  fmt::print(
      "largest relative error on {} photos against libtorch as it is: Roomwise {:.1e}, "
      "libtorch optimised {:.1e}\n",
      inputs.size(), error, error_of_optimised);

  const Tensor& input = inputs.front();
  const at::Tensor picture = tensor_of(input);
  std::vector<double> ours, as_it_is, best, ratios;
  for (int round = 0; round < *rounds; ++round) {
    ours.push_back(time_of([&] { (void)need(executor->run({&input, 1})); }));
    as_it_is.push_back(time_of([&] { (void)need(plain.forward(picture, false)); }));
    best.push_back(time_of([&] { (void)fast.forward({picture}); }));
    ratios.push_back(ours.back() / best.back());
  }
  fmt::print("CPU-ms a picture, median (range) of {} rounds\n", *rounds);
  fmt::print("  Roomwise                          {}\n", text_of(ours));
  fmt::print("  libtorch {} as it is          {}\n", TORCH_VERSION, text_of(as_it_is));
  fmt::print("  libtorch {} optimised         {}\n", TORCH_VERSION, text_of(best));
  fmt::print("  Roomwise / libtorch optimised     {}\n", text_of(ratios));
  const bool passed = error < 1e-4;
  if (!passed) fmt::print(stderr, "the results differ\n");
  return passed ? 0 : 1;
}
