#include "roomwise/network/graph/passes.h"

#include <gmock/gmock.h>

#include "roomwise/network/executor/memory_plan.h"
#include "roomwise/network/graph/lowering.h"
#include "roomwise/network/testing/tiny_runs.h"

namespace roomwise::network {
namespace {

using namespace testing;
using Integers = std::vector<std::int64_t>;

// A pad, convolutions with batch normalisation and activations, a sum, joins, a channel shuffle and
// a permutation written as a convolution: something for every pass.
TinyGraph busy_graph() {
  std::vector<float> permutation(32 * 32, 0.F);
  for (std::size_t i = 0; i < 32; ++i) permutation[i * 32 + (i * 5) % 32] = 1;
  return {
      {layer("Pad", {"picture", "pads"}, {"padded"}),
       layer("Conv", {"padded", "w1"}, {"c1"},
             {attribute("strides", Integers{2, 2}), attribute("kernel_shape", Integers{3, 3})}),
       layer("BatchNormalization", {"c1", "g", "b", "m", "v"}, {"n1"}),
       layer("Sigmoid", {"n1"}, {"s1"}), layer("Mul", {"n1", "s1"}, {"a1"}),
       layer("Conv", {"a1", "w2"}, {"c2"},
             {attribute("pads", Integers{1, 1, 1, 1}), attribute("kernel_shape", Integers{3, 3})}),
       layer("Add", {"c2", "a1"}, {"sum"}), layer("Relu", {"sum"}, {"a2"}),
       layer("Concat", {"a1", "a2"}, {"joined"}, {attribute("axis", 1)}),
       layer("Conv", {"joined", "permutation"}, {"permuted"},
             {attribute("kernel_shape", Integers{1, 1})}),
       layer("Reshape", {"permuted", "split"}, {"groups"}),
       layer("Transpose", {"groups"}, {"swapped"}, {attribute("perm", Integers{0, 2, 1, 3, 4})}),
       layer("Reshape", {"swapped", "whole"}, {"shuffled"}),
       layer("Split", {"shuffled"}, {"left", "right"},
             {attribute("axis", 1), attribute("split", Integers{13, 19})}),
       layer("Add", {"two", "two"}, {"four"}), layer("Mul", {"left", "four"}, {"scaled"}),
       layer("Concat", {"right", "scaled", "right"}, {"out"}, {attribute("axis", 1)})},
      {tensor("pads", {8}, Integers{0, 0, 0, 0, 0, 0, 1, 1}),
       random_weights("w1", {16, 3, 3, 3}, 1), random_weights("g", {16}, 2),
       random_weights("b", {16}, 3), random_weights("m", {16}, 4),
       tensor("v", {16}, std::vector<float>(16, 2.F)), random_weights("w2", {16, 16, 3, 3}, 5),
       tensor("permutation", {32, 32, 1, 1}, permutation),
       tensor("split", {5}, Integers{1, 2, 16, 5, 6}), tensor("whole", {4}, Integers{1, 32, 5, 6}),
       tensor("two", {}, std::vector<float>{2})},
      {1, 3, 10, 12},
      {{"out", {}}}};
}

Program program_of(const TinyGraph& tiny, const PassOptions& options) {
  const std::string file = onnx(tiny);
  const auto graph = read_onnx_graph(bytes_of(file));
  EXPECT_TRUE(graph.has_value());
  const Shape input = input_shape(tiny);
  auto program = lower(*graph, {&input, 1}, {}, options.folds_constants);
  EXPECT_TRUE(program.has_value()) << program.error().message;
  return run_passes(*program, options);
}

template <typename Operation>
std::size_t count(const Program& program) {
  return static_cast<std::size_t>(std::ranges::count_if(program.layers, [](const Layer& layer) {
    return std::holds_alternative<Operation>(layer.operation);
  }));
}

const std::vector<std::pair<const char*, bool PassOptions::*>> kPasses = {
    {"constants", &PassOptions::folds_constants}, {"padding", &PassOptions::folds_padding},
    {"scales", &PassOptions::folds_scales},       {"activations", &PassOptions::fuses_activations},
    {"residuals", &PassOptions::fuses_residuals}, {"gathers", &PassOptions::combines_gathers},
    {"means", &PassOptions::swaps_means},         {"joins", &PassOptions::concat_in_place},
    {"Winograd", &PassOptions::uses_winograd}};

PassOptions no_passes() {
  PassOptions none;
  for (const auto& [name, pass] : kPasses) none.*pass = false;
  return none;
}

TEST(Passes, LeaveWhatComesOutAsItWas) {
  const TinyGraph graph = busy_graph();
  const std::string file = onnx(graph);
  const Tensor input = random_tensor(input_shape(graph));
  ExecutorOptions options;
  options.passes = no_passes();
  const auto plain = run(file, input, options);
  ASSERT_OK(plain);
  EXPECT_LT(relative_error(plain->front().values, OpenCvNetwork(bytes_of(file)).run(input)), 1e-5);
  const auto expect_same = [&](const char* what) {
    const auto outputs = run(file, input, options);
    ASSERT_OK(outputs) << what;
    EXPECT_LT(relative_error(outputs->front().values, plain->front().values), 1e-5) << what;
  };
  for (const auto& [name, pass] : kPasses) {
    options.passes = no_passes();
    options.passes.*pass = true;
    expect_same(name);
    options.passes = {};
    options.passes.*pass = false;
    expect_same(name);
  }
  options.passes = {};
  expect_same("all");
}

// That each pass does what it is for.
TEST(Passes, TakeLayersAway) {
  const TinyGraph graph = busy_graph();
  for (const auto& [name, pass] : kPasses) {
    // The last two are of the plan, not of the program.
    if (pass == &PassOptions::swaps_means || pass == &PassOptions::concat_in_place ||
        pass == &PassOptions::uses_winograd) {
      continue;
    }
    PassOptions one = no_passes();
    one.*pass = true;
    EXPECT_LT(program_of(graph, one).layers.size(), program_of(graph, no_passes()).layers.size())
        << name;
  }
}

// A mean (with or without the padding's zeros) of many channels, then few outputs.
TEST(Passes, SwapsMeansSoThatTheyAreOfFewChannels) {
  for (const int counts_padding : {0, 1}) {
    const TinyGraph graph{
        {layer("AveragePool", {"picture"}, {"m"},
               {attribute("kernel_shape", {3, 3}), attribute("pads", {1, 1, 1, 1}),
                attribute("count_include_pad", counts_padding)}),
         layer("Conv", {"m", "w", "b"}, {"c"}), layer("Relu", {"c"}, {"out"})},
        {random_weights("w", {5, 24, 1, 1}, 1), random_weights("b", {5}, 2)},
        {1, 24, 7, 6},
        {{"out", {1, 5, 7, 6}}}};
    const Program program = program_of(graph, {});
    ASSERT_NE(program.layers[0].as<Convolution>(), nullptr);
    ASSERT_NE(program.layers[1].as<Pooling>(), nullptr);
    EXPECT_EQ(program.values[program.layers[1].output].shape[1], 5);
    const Tensor input = random_tensor(input_shape(graph));
    ExecutorOptions unswapped;
    unswapped.passes.swaps_means = false;
    const auto outputs = run(onnx(graph), input), expected = run(onnx(graph), input, unswapped);
    ASSERT_OK(outputs);
    ASSERT_OK(expected);
    EXPECT_LT(relative_error(outputs->front().values, expected->front().values), 1e-5);
  }
}

TEST(Passes, LeaveTwoConvolutionsAndTwoGathers) {
  const Program program = program_of(busy_graph(), {});
  EXPECT_EQ(count<Convolution>(program), 2u);
  EXPECT_EQ(count<Activation>(program), 0u);
  EXPECT_EQ(count<View>(program), 0u);
  EXPECT_EQ(count<Permutation>(program), 0u);
  EXPECT_EQ(count<AxisSlices>(program), 2u) << "what is scaled, and the output";
  EXPECT_EQ(count<Arithmetic>(program), 1u);
  EXPECT_EQ(program.layers.size(), 5u);
}

TEST(Passes, KnowHardSwishWrittenOut) {
  const TinyGraph graph{{layer("Conv", {"picture", "w"}, {"c"}),
                         layer("HardSigmoid", {"c"}, {"gate"}, {attribute("alpha", 1.0F / 6)}),
                         layer("Mul", {"c", "gate"}, {"out"})},
                        {random_weights("w", {8, 3, 1, 1}, 1)},
                        {1, 3, 4, 4},
                        {{"out", {}}}};
  EXPECT_EQ(program_of(graph, {}).layers.size(), 1u);
  const Tensor input = random_tensor(input_shape(graph));
  ExecutorOptions options;
  const auto fused = run(onnx(graph), input, options);
  options.passes = no_passes();
  const auto apart = run(onnx(graph), input, options);
  ASSERT_OK(fused);
  ASSERT_OK(apart);
  EXPECT_LT(relative_error(fused->front().values, apart->front().values), 1e-5);
}

// A value that is asked for, or read twice, must not disappear in a convolution.
TEST(Passes, KeepWhatIsAskedFor) {
  const TinyGraph graph = busy_graph();
  const std::string file = onnx(graph);
  const Tensor input = random_tensor(input_shape(graph));
  ExecutorOptions options;
  options.outputs = {"c1", "sum", "a1_node", "joined", "out", "picture"};
  const auto all = run(file, input, options);
  options.passes = no_passes();
  const auto plain = run(file, input, options);
  ASSERT_OK(all);
  ASSERT_OK(plain);
  for (std::size_t i = 0; i < options.outputs.size(); ++i) {
    EXPECT_EQ((*all)[i].shape, (*plain)[i].shape) << options.outputs[i];
    EXPECT_LT(relative_error((*all)[i].values, (*plain)[i].values), 1e-5) << options.outputs[i];
  }
  EXPECT_EQ(all->back().values, input.values);
}

// The sum is written over the residual only where nobody reads that afterwards.
TEST(Passes, SumsSpareWhatIsStillRead) {
  const std::vector<std::string> kOne{attribute("kernel_shape", Integers{1, 1})};
  const TinyGraph graph{
      {layer("Conv", {"picture", "w"}, {"a"}, kOne), layer("Conv", {"a", "w"}, {"b"}, kOne),
       layer("Add", {"a", "b"}, {"first"}), layer("Conv", {"first", "w"}, {"c"}, kOne),
       layer("Add", {"c", "first"}, {"second"}), layer("Mul", {"second", "a"}, {"out"})},
      {random_weights("w", {16, 16, 1, 1}, 1)},
      {1, 16, 5, 5},
      {{"out", {}}}};
  expect_like_opencv(graph);
}

TEST(MemoryPlan, NeverOverlapsWhatIsNeededTogether) {
  RandomStream random(3);
  for (int round = 0; round < 50; ++round) {
    std::vector<Buffer> buffers;
    std::size_t sum = 0;
    for (std::size_t i = 0; i < 40; ++i) {
      const auto first = static_cast<std::size_t>(random.index(40));
      buffers.push_back({1 + random.index(5000), first, first + random.index(6)});
      sum += buffers.back().bytes + 64;
    }
    const MemoryPlan plan = plan_memory(buffers);
    EXPECT_LT(plan.bytes, sum / 2);
    for (std::size_t i = 0; i < buffers.size(); ++i) {
      EXPECT_EQ(plan.offsets[i] % 64, 0u);
      EXPECT_LE(plan.offsets[i] + buffers[i].bytes, plan.bytes);
      for (std::size_t j = 0; j < i; ++j) {
        const bool together =
            buffers[i].first <= buffers[j].last && buffers[j].first <= buffers[i].last;
        const bool apart = plan.offsets[i] + buffers[i].bytes <= plan.offsets[j] ||
                           plan.offsets[j] + buffers[j].bytes <= plan.offsets[i];
        EXPECT_TRUE(!together || apart);
      }
    }
  }
}

}  // namespace
}  // namespace roomwise::network
