#include "roomwise/network/executor/executor.h"

#include <gmock/gmock.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <mutex>

#include "roomwise/base/file.h"
#include "roomwise/base/thread_pool.h"
#include "roomwise/network/testing/tiny_runs.h"

namespace roomwise::network {
namespace {

using namespace testing;
using roomwise::testing::find_model;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Free in batch, height and width.
TinyGraph free_graph() {
  return {{layer("Conv", {"picture", "w"}, {"c"}), layer("Relu", {"c"}, {"r"}),
           layer("GlobalAveragePool", {"r"}, {"pooled"}), layer("Flatten", {"pooled"}, {"out"})},
          {random_weights("w", {20, 3, 3, 3}, 1)},
          {0, 3, 0, 0},
          {{"out", {}}}};
}

TEST(Executor, TakesTheSizesThatTheFileLeavesOpen) {
  const auto executor = load(onnx(free_graph()));
  ASSERT_OK(executor);
  EXPECT_THAT((*executor)->inputs()[0].shape, ElementsAre(-1, 3, -1, -1));
  for (const Shape& shape : {Shape{1, 3, 8, 8}, Shape{1, 3, 5, 9}, Shape{4, 3, 8, 8}}) {
    const Tensor input = random_tensor(shape);
    const auto outputs = (*executor)->run({&input, 1});
    ASSERT_OK(outputs);
    EXPECT_THAT(outputs->front().shape, ElementsAre(shape[0], 20));
  }
}

TEST(Executor, ABatchGivesWhatItsPicturesGive) {
  const auto executor = load(onnx(free_graph()));
  ASSERT_OK(executor);
  for (const std::int64_t size : {2, 5, 16}) {
    Tensor batch{{size, 3, 8, 8}, {}};
    std::vector<Tensor> pictures;
    for (std::int64_t i = 0; i < size; ++i) {
      pictures.push_back(random_tensor({1, 3, 8, 8}, static_cast<std::uint64_t>(i) + 1));
      batch.values.insert(batch.values.end(), pictures.back().values.begin(),
                          pictures.back().values.end());
    }
    const auto together = (*executor)->run({&batch, 1});
    ASSERT_OK(together);
    std::vector<float> singles;
    for (const Tensor& picture : pictures) {
      const auto alone = (*executor)->run({&picture, 1});
      ASSERT_OK(alone);
      singles.insert(singles.end(), alone->front().values.begin(), alone->front().values.end());
    }
    EXPECT_LT(relative_error(together->front().values, singles), 1e-5);
    for (const std::size_t threads : {1U, 3U}) {
      const auto apart = (*executor)->run_batch(pictures, threads);
      ASSERT_OK(apart);
      std::vector<float> joined;
      for (const auto& outputs : *apart)
        joined.insert(joined.end(), outputs[0].values.begin(), outputs[0].values.end());
      EXPECT_EQ(joined, singles) << threads << " threads";
    }
  }
}

// Sizes that nobody has asked for yet, several at once and each by several threads.
TEST(Executor, TakesNewSizesFromSeveralThreads) {
  const auto executor = load(onnx(free_graph()));
  ASSERT_OK(executor);
  std::vector<Tensor> pictures;
  for (std::uint64_t i = 0; i < 24; ++i)
    pictures.push_back(random_tensor({1, 3, 5, 4 + static_cast<std::int64_t>(i % 6)}, i + 1));
  const auto together = (*executor)->run_batch(pictures, 4);
  ASSERT_OK(together);
  const auto alone = load(onnx(free_graph()));
  ASSERT_OK(alone);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const auto expected = (*alone)->run({&pictures[i], 1});
    ASSERT_OK(expected);
    EXPECT_EQ((*together)[i][0].values, expected->front().values) << i;
  }
}

// Sizes that do not fit are refused to each that asks, and those that do fit go on.
TEST(Executor, RefusesNewSizesToSeveralThreads) {
  const auto executor = load(onnx(free_graph()));
  ASSERT_OK(executor);
  std::vector<bool> is_right(24, false);
  std::mutex mutex;
  ThreadPool(4).parallel_for(is_right.size(), [&](std::size_t i) {
    const bool fits = i % 3 == 0;
    const Tensor picture = random_tensor({1, 3, fits ? 6 : 2, 4});
    const auto outputs = (*executor)->run({&picture, 1});
    const std::scoped_lock lock(mutex);
    is_right[i] = outputs.has_value() == fits;
  });
  EXPECT_THAT(is_right, Each(true));
}

TEST(Executor, TooLittleMemoryIsAnError) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers end the program themselves";
#endif
  // A run takes a quarter of a gigabyte.
  const auto executor = load(onnx(TinyGraph{
      {layer("Resize", {"picture", "", "scales"}, {"large"}, {attribute("mode", "nearest")}),
       layer("ReduceMean", {"large"}, {"out"}, {attribute("axes", {3})})},
      {tensor("scales", {4}, std::vector<float>{1, 1, 8192, 8192})},
      {1, 1, 1, 1},
      {{"out", {}}}}));
  ASSERT_OK(executor);
  const auto run_in_little = [&] {
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const auto now = pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    const rlimit little{now + (std::size_t{64} << 20), RLIM_INFINITY};
    if (pages == 0 || setrlimit(RLIMIT_AS, &little) != 0) std::_Exit(2);
    const Tensor picture{{1, 1, 1, 1}, {2}};
    const auto outputs = (*executor)->run({&picture, 1});
    if (!outputs) std::fputs(outputs.error().message.c_str(), stderr);
    std::_Exit(outputs ? 0 : 1);
  };
  EXPECT_EXIT(run_in_little(), ::testing::ExitedWithCode(1), "not enough memory");
}

TEST(Executor, NamesWhatDoesNotFit) {
  const auto executor = load(onnx(free_graph()));
  ASSERT_OK(executor);
  const Tensor gray = random_tensor({1, 1, 8, 8});
  EXPECT_ERROR((*executor)->run({&gray, 1}), "input \"picture\" takes ?x3x?x?, not 1x1x8x8");
  const Tensor small = random_tensor({1, 3, 2, 2});
  EXPECT_ERROR((*executor)->run({&small, 1}), "(Conv, opset 11): its window of 3 is larger");
  Tensor torn = random_tensor({1, 3, 8, 8});
  torn.values.pop_back();
  EXPECT_ERROR((*executor)->run({&torn, 1}), "has 191 values for the shape 1x3x8x8");
  EXPECT_ERROR((*executor)->run({}), "has 1 inputs, not 0");
  ExecutorOptions options;
  options.outputs = {"pool5"};
  TinyGraph fixed = free_graph();
  fixed.input = {1, 3, 8, 8};
  EXPECT_ERROR(load(onnx(fixed), options),
               "no output or node named \"pool5\"; its outputs are out");
}

class RealNetwork : public ::testing::TestWithParam<const char*> {};

Tensor random_picture(const OnnxGraph& graph) {
  return random_tensor(graph.inputs.front().shape, 11);
}

TEST_P(RealNetwork, GivesWhatOpenCvGives) {
  const auto file = find_model(GetParam());
  ROOMWISE_REQUIRE_FILE(file);
  const auto bytes = read_file(*file);
  ASSERT_OK(bytes);
  auto graph = read_onnx_graph(*bytes);
  ASSERT_OK(graph);
  const Tensor input = random_picture(*graph);
  const auto executor = Executor::create(std::move(*graph));
  ASSERT_OK(executor);
  const auto outputs = (*executor)->run({&input, 1});
  ASSERT_OK(outputs);
  EXPECT_LT(relative_error(outputs->front().values, OpenCvNetwork(*bytes).run(input)), 1e-4);
}

TEST_P(RealNetwork, GivesTheSameWithoutPasses) {
  const auto file = find_model(GetParam());
  ROOMWISE_REQUIRE_FILE(file);
  const auto bytes = read_file(*file);
  ASSERT_OK(bytes);
  const auto graph = read_onnx_graph(*bytes);
  ASSERT_OK(graph);
  const Tensor input = random_picture(*graph);
  const auto outputs_with = [&](const PassOptions& passes) {
    ExecutorOptions options;
    options.passes = passes;
    const auto executor = Executor::create(*graph, options);
    EXPECT_TRUE(executor.has_value()) << executor.error().message;
    return (*executor)->run({&input, 1})->front().values;
  };
  const PassOptions none{false, false, false, false, false, false, false, false, false};
  // Winograd's way rounds otherwise.
  EXPECT_LT(relative_error(outputs_with({}), outputs_with(none)), 3e-5);
}

TEST_P(RealNetwork, GivesTheSameBitsFromSeveralThreads) {
  const auto file = find_model(GetParam());
  ROOMWISE_REQUIRE_FILE(file);
  const auto bytes = read_file(*file);
  ASSERT_OK(bytes);
  auto graph = read_onnx_graph(*bytes);
  ASSERT_OK(graph);
  const std::vector<Tensor> pictures(5, random_picture(*graph));
  const auto executor = Executor::create(std::move(*graph));
  ASSERT_OK(executor);
  const auto alone = (*executor)->run(std::span(pictures).first(1));
  ASSERT_OK(alone);
  const auto together = (*executor)->run_batch(pictures, 3);
  ASSERT_OK(together);
  for (const auto& outputs : *together) EXPECT_EQ(outputs[0].values, alone->front().values);
}

TEST_P(RealNetwork, GivesTheSameBitsWhereThreadsShareAPicture) {
  const auto file = find_model(GetParam());
  ROOMWISE_REQUIRE_FILE(file);
  const auto bytes = read_file(*file);
  ASSERT_OK(bytes);
  const auto graph = read_onnx_graph(*bytes);
  ASSERT_OK(graph);
  const Tensor input = random_picture(*graph);
  const auto outputs_of = [&](std::size_t threads) {
    ExecutorOptions options;
    options.threads_per_input = threads;
    const auto executor = Executor::create(*graph, options);
    EXPECT_TRUE(executor.has_value()) << executor.error().message;
    return (*executor)->run({&input, 1})->front().values;
  };
  const auto alone = outputs_of(1);
  for (const std::size_t threads : {2U, 3U, 4U}) EXPECT_EQ(outputs_of(threads), alone) << threads;
}

INSTANTIATE_TEST_SUITE_P(Models, RealNetwork,
                         ::testing::Values("mobilenet-v2-imagenet.onnx", "nanodet-plus-m-416.onnx",
                                           "inception-2015-12-05-trunk.onnx"),
                         [](const auto& each) {
                           std::string name = each.param;
                           std::erase_if(name, [](char c) { return std::isalnum(c) == 0; });
                           return name;
                         });

}  // namespace
}  // namespace roomwise::network
