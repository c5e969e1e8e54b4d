#include "roomwise/network/executor/quantization.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>
#include <set>

#include "roomwise/network/executor/checked_quantization.h"
#include "roomwise/network/executor/plan_builder.h"
#include "roomwise/network/graph/graph_builder.h"
#include "roomwise/network/graph/lowering.h"
#include "roomwise/network/graph/onnx_graph.h"
#include "roomwise/network/testing/more_layers.h"
#include "roomwise/network/testing/tiny_runs.h"

namespace roomwise::network {
namespace {

using namespace testing;

double cosine(std::span<const float> a, std::span<const float> b) {
  double product = 0, of_a = 0, of_b = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    product += static_cast<double>(a[i]) * b[i];
    of_a += static_cast<double>(a[i]) * a[i];
    of_b += static_cast<double>(b[i]) * b[i];
  }
  return product / std::sqrt(of_a * of_b);
}

// Branches that are joined, a mean, a maximum, a sum, a depthwise convolution, and activations
// that keep the scale and that do not.
OnnxGraph branched_graph() {
  GraphBuilder builder({5, false});
  auto x = builder.input("picture", {1, 3, 20, 18});
  x = builder.relu(builder.convolution(x, "stem", {16, {3, 3}, {2, 2}, {1, 1}}), "stem.relu");
  const auto a = builder.relu(builder.convolution(x, "a", {24, {3, 3}, {1, 1}, {1, 1}}), "a.relu");
  const auto mean = builder.average_pool(x, "mean", {{3, 3}, {1, 1}, {1, 1}});
  const auto b = testing::relu6(
      builder, builder.convolution(mean, "b", {8, {1, 1}, {1, 1}, {0, 0}, 1, true}), "b.relu6");
  const auto c = builder.max_pool(x, "c", {{3, 3}, {1, 1}, {1, 1}});
  x = builder.concat(std::array{a, b, c}, "joined");
  auto y = testing::hard_swish(
      builder, builder.convolution(x, "deep", {48, {3, 3}, {1, 1}, {1, 1}, 48}), "deep.swish");
  y = builder.convolution(y, "linear", {48});
  x = builder.add(y, x, "sum");
  x = builder.relu(builder.convolution(x, "last", {40}), "last.relu");
  builder.output(builder.flatten(builder.global_average_pool(x, "pool"), "features"));
  return builder.take();
}

std::vector<Tensor> some_pictures() {
  std::vector<Tensor> pictures;
  for (std::uint64_t seed = 1; seed < 5; ++seed)
    pictures.push_back(random_tensor({1, 3, 20, 18}, seed));
  return pictures;
}

// Measured on these inputs.
ExecutorOptions in_eight_bits(const OnnxGraph& graph, std::span<const Tensor> inputs,
                              std::int64_t min_channels = 1) {
  auto ranges = calibrate_eight_bits(graph, {}, inputs);
  EXPECT_OK(ranges);
  if (!ranges) return {};
  ranges->min_channels = min_channels;
  ExecutorOptions options;
  options.eight_bits = *std::move(ranges);
  return options;
}

TEST(Quantization, HoldsWhatConvolutionsLookAtInEightBits) {
  const OnnxGraph graph = branched_graph();
  const Shape shape{1, 3, 20, 18};
  auto program = lower(graph, {&shape, 1}, {});
  ASSERT_OK(program);
  *program = run_passes(*program, {});
  const std::vector<Tensor> pictures = some_pictures();
  const auto ranges = calibrate_ranges(*program, pictures);
  ASSERT_OK(ranges);
  quantize(*program, *ranges);
  EXPECT_FALSE(program->values[program->inputs[0]].eight_bits.has_value());
  std::size_t convolutions = 0, joins = 0;
  for (const Layer& layer : program->layers) {
    const auto& of_input = program->values[layer.inputs[0]].eight_bits;
    if (layer.as<Convolution>() != nullptr) convolutions += of_input ? 1 : 0;
    if (layer.as<AxisSlices>() == nullptr) continue;
    ++joins;
    const auto& of_output = program->values[layer.output].eight_bits;
    ASSERT_TRUE(of_output.has_value());
    EXPECT_FALSE(of_output->is_signed);
    for (const ValueId input : layer.inputs) {
      ASSERT_TRUE(program->values[input].eight_bits.has_value());
      EXPECT_EQ(program->values[input].eight_bits->step, of_output->step);
    }
  }
  EXPECT_EQ(convolutions, 5u) << "all but the one that looks at the picture";
  EXPECT_EQ(joins, 1u);
}

void expect_close_in_eight_bits() {
  const OnnxGraph graph = branched_graph();
  const auto exact = Executor::create(graph),
             rounded = Executor::create(graph, in_eight_bits(graph, some_pictures()));
  ASSERT_OK(exact);
  ASSERT_OK(rounded);
  const Tensor picture = random_tensor({1, 3, 20, 18}, 77);
  const auto expected = (*exact)->run({&picture, 1}), outputs = (*rounded)->run({&picture, 1});
  ASSERT_OK(expected);
  ASSERT_OK(outputs);
  EXPECT_NE(outputs->front().values, expected->front().values) << "nothing is in 8 bits";
  EXPECT_GT(cosine(outputs->front().values, expected->front().values), 0.998);
  const auto again = (*rounded)->run({&picture, 1});
  ASSERT_OK(again);
  EXPECT_EQ(again->front().values, outputs->front().values);
}

TEST(Quantization, GivesNearlyTheSame) {
  expect_close_in_eight_bits();
}

// The largest inputs and the largest weights, all of one sign: two products of 255 and 127 do not
// fit into 16 bits, in which processors without VNNI add them up.
void expect_no_overflow() {
  Constant ones;
  ones.shape = {16, 32, 3, 3};
  ones.floats.assign(element_count(ones.shape), 1.0F);
  GraphBuilder builder;
  auto x = builder.input("picture", {1, 32, 8, 8});
  x = builder.convolution(x, "c", {16, {3, 3}});
  builder.output(x);
  OnnxGraph graph = builder.take();
  graph.constants["c.weight"] = std::make_shared<const Constant>(ones);
  const Tensor bright{{1, 32, 8, 8}, std::vector<float>(32 * 64, 1.0F)};
  const auto executor = Executor::create(graph, in_eight_bits(graph, {&bright, 1}));
  ASSERT_OK(executor);
  const auto outputs = (*executor)->run({&bright, 1});
  ASSERT_OK(outputs);
  for (const float value : outputs->front().values) EXPECT_NEAR(value, 288, 0.5);
}

TEST(Quantization, DoesNotOverflow) {
  expect_no_overflow();
}

// oneDNN reads which instructions it may use when it is first used: in a process of its own.
TEST(Quantization, IsAsGoodWithoutVnni) {
  const auto run_held_to_avx2 = [] {
    const std::string self = std::filesystem::read_symlink("/proc/self/exe").string();
    const std::string command =
        "DNNL_MAX_CPU_ISA=AVX2 '" + self +
        "' --gtest_filter='Quantization.*-Quantization.IsAsGoodWithoutVnni' > /dev/null";
    return std::system(command.c_str());
  };
  EXPECT_EQ(run_held_to_avx2(), 0);
}

TEST(Quantization, WeightsAreOfSevenBitsWithoutVnni) {
  using dnnl::cpu_isa;
  EXPECT_EQ(max_weight_in_eight_bits(cpu_isa::sse41), 63);
  EXPECT_EQ(max_weight_in_eight_bits(cpu_isa::avx2), 63);
  EXPECT_EQ(max_weight_in_eight_bits(cpu_isa::avx512_core), 63);
  EXPECT_EQ(max_weight_in_eight_bits(cpu_isa::avx2_vnni), 127);
  EXPECT_EQ(max_weight_in_eight_bits(cpu_isa::avx512_core_vnni), 127);
  EXPECT_EQ(max_weight_in_eight_bits(cpu_isa::avx512_core_amx), 127);
}

double relative_error(std::span<const float> a, std::span<const float> exact) {
  double difference = 0, length = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference += std::pow(static_cast<double>(a[i]) - exact[i], 2);
    length += std::pow(static_cast<double>(exact[i]), 2);
  }
  return std::sqrt(difference / length);
}

TEST(Quantization, IsUsedOnlyWhereItIsNearEnough) {
  const OnnxGraph graph = branched_graph();
  const std::vector<Tensor> pictures = some_pictures();
  const std::vector<Tensor> held_out{random_tensor({1, 3, 20, 18}, 8),
                                     random_tensor({1, 3, 20, 18}, 9)};
  const std::array<std::size_t, 1> scores{0};
  const auto near = checked_quantization(graph, {}, pictures, held_out, scores, {0.99, 0.0});
  ASSERT_OK(near);
  EXPECT_TRUE(near->report.is_used) << near->report.reason;
  const auto far = checked_quantization(graph, {}, pictures, held_out, scores, {0.9999999, 0.0});
  ASSERT_OK(far);
  EXPECT_FALSE(far->report.is_used);
  EXPECT_THAT(far->report.reason, ::testing::HasSubstr("below 0.9999999"));
  const auto exact = Executor::create(graph);
  ASSERT_OK(exact);
  const auto expected = (*exact)->run(std::span(held_out).first(1));
  const auto outputs = far->executor->run(std::span(held_out).first(1));
  const auto rounded = near->executor->run(std::span(held_out).first(1));
  ASSERT_OK(expected);
  ASSERT_OK(outputs);
  ASSERT_OK(rounded);
  EXPECT_EQ(outputs->front().values, expected->front().values);
  EXPECT_NE(rounded->front().values, expected->front().values);
  EXPECT_TRUE(near->eight_bits.has_value());
  EXPECT_FALSE(far->eight_bits.has_value());
  EXPECT_ERROR(checked_quantization(graph, {}, pictures, {}, scores), "others to be checked on");
  EXPECT_ERROR(checked_quantization(graph, {}, {}, held_out, scores), "inputs to measure on");
}

TEST(Quantization, TellsHowManyRunsAreDoneAndStopsWhereThatFails) {
  const std::vector<Tensor> pictures = some_pictures();
  const std::vector<Tensor> held_out{random_tensor({1, 3, 20, 18}, 8),
                                     random_tensor({1, 3, 20, 18}, 9)};
  std::vector<std::size_t> told;
  const RunsDone tell = [&](std::size_t done, std::size_t of) -> Expected<void> {
    EXPECT_EQ(of, pictures.size() + 2 * held_out.size());
    told.push_back(done);
    return {};
  };
  ASSERT_OK(
      checked_quantization(branched_graph(), {}, pictures, held_out, {}, {0.9, 0.0}, 1, tell));
  EXPECT_THAT(told, ::testing::ElementsAre(2, 2 + pictures.size(), 4 + pictures.size()));
  const RunsDone stop = [](std::size_t, std::size_t) -> Expected<void> { return fail("enough"); };
  EXPECT_ERROR(
      checked_quantization(branched_graph(), {}, pictures, held_out, {}, {0.9, 0.0}, 1, stop),
      "enough");
}

// Few channels, then many, and few that are joined to many.
OnnxGraph widening_graph() {
  GraphBuilder builder({5, false});
  auto x = builder.input("picture", {1, 3, 20, 18});
  x = builder.relu(builder.convolution(x, "narrow", {8, {3, 3}, {2, 2}, {1, 1}}), "narrow.relu");
  x = builder.relu(builder.convolution(x, "wide", {64, {3, 3}, {1, 1}, {1, 1}}), "wide.relu");
  const auto branch = builder.relu(builder.convolution(x, "branch", {12}), "branch.relu");
  x = builder.concat(std::array{x, branch}, "joined");
  x = builder.relu(builder.convolution(x, "last", {40}), "last.relu");
  builder.output(builder.flatten(builder.global_average_pool(x, "pool"), "features"));
  return builder.take();
}

TEST(Quantization, LeavesFewChannelsInFloatsWhereItIsToldTo) {
  const Shape shape{1, 3, 20, 18};
  auto program = lower(widening_graph(), {&shape, 1}, {});
  ASSERT_OK(program);
  *program = run_passes(*program, {});
  const std::vector<Tensor> pictures = some_pictures();
  const auto ranges = calibrate_ranges(*program, pictures);
  ASSERT_OK(ranges);
  const auto channels_in_eight_bits = [&](std::int64_t min_channels) {
    Program rounded = *program;
    quantize(rounded, *ranges, min_channels);
    std::set<std::int64_t> channels;
    for (const Value& value : rounded.values) {
      if (value.eight_bits) channels.insert(value.shape[1]);
    }
    return channels;
  };
  using Channels = std::set<std::int64_t>;
  EXPECT_EQ(channels_in_eight_bits(1), (Channels{8, 12, 64, 76}));
  EXPECT_EQ(channels_in_eight_bits(64), (Channels{64, 76})) << "the 12 that are joined, neither";
  EXPECT_EQ(channels_in_eight_bits(65), (Channels{76}));
}

TEST(Quantization, LeavesFewChannelsInFloatsWhereThatMakesItNearEnough) {
  const OnnxGraph graph = widening_graph();
  const std::vector<Tensor> pictures = some_pictures();
  const Tensor picture = random_tensor({1, 3, 20, 18}, 8);
  const auto exact = Executor::create(graph),
             whole = Executor::create(graph, in_eight_bits(graph, pictures)),
             mixed = Executor::create(graph, in_eight_bits(graph, pictures, 65));
  ASSERT_OK(exact);
  ASSERT_OK(whole);
  ASSERT_OK(mixed);
  const auto outputs_of = [&](const auto& executor) {
    return (*executor)->run({&picture, 1})->front().values;
  };
  const std::vector<float> expected = outputs_of(exact);
  const double whole_error = relative_error(outputs_of(whole), expected);
  const double mixed_error = relative_error(outputs_of(mixed), expected);
  ASSERT_LT(mixed_error, whole_error);
  ASSERT_GT(mixed_error, 0);

  const auto checked_by = [&](double max_error) {
    return checked_quantization(graph, {}, pictures, {&picture, 1}, {},
                                {.min_cosine = 0, .max_error = max_error});
  };
  const auto easy = checked_by(2 * whole_error),
             between = checked_by((whole_error + mixed_error) / 2),
             hard = checked_by(mixed_error / 2);
  ASSERT_OK(easy);
  ASSERT_OK(between);
  ASSERT_OK(hard);
  EXPECT_TRUE(easy->report.is_used);
  EXPECT_EQ(easy->report.min_channels, 1);
  EXPECT_TRUE(between->report.is_used);
  EXPECT_EQ(between->report.min_channels, 65);
  EXPECT_NEAR(between->report.mean_error.front(), mixed_error, 1e-9);
  EXPECT_EQ(between->executor->run({&picture, 1})->front().values, outputs_of(mixed));
  EXPECT_FALSE(hard->report.is_used);
  EXPECT_EQ(hard->executor->run({&picture, 1})->front().values, expected);
}

// Outputs in 8 bits are near those in floats, in size too.
void expect_near(const std::string& file) {
  const auto graph =
      read_onnx_graph(std::span(reinterpret_cast<const std::uint8_t*>(file.data()), file.size()));
  ASSERT_OK(graph);
  const auto exact = Executor::create(*graph);
  const auto rounded = Executor::create(*graph, in_eight_bits(*graph, some_pictures()));
  ASSERT_OK(exact);
  ASSERT_OK(rounded);
  const Tensor picture = random_tensor({1, 3, 20, 18}, 8);
  const auto expected = (*exact)->run({&picture, 1});
  const auto outputs = (*rounded)->run({&picture, 1});
  ASSERT_OK(expected);
  ASSERT_OK(outputs);
  for (std::size_t i = 0; i < outputs->size(); ++i)
    EXPECT_LT(relative_error((*outputs)[i].values, (*expected)[i].values), 0.1) << "output " << i;
}

const std::string kPads = attribute("pads", std::vector<std::int64_t>{1, 1, 1, 1});

// A half of a value that a convolution looks at goes on by itself, and is joined again.
TEST(Quantization, HalvesOfWhatIsInEightBitsAreTakenFromFloats) {
  const auto numbers = [](const char* name, std::int64_t value) {
    return tensor(name, {1}, std::vector<std::int64_t>{value});
  };
  expect_near(onnx(TinyGraph{
      {layer("Conv", {"picture", "w1"}, {"c1"}, {kPads}), layer("Relu", {"c1"}, {"x"}, {}),
       layer("Slice", {"x", "begin", "end", "axis"}, {"half"}, {}),
       layer("Conv", {"half", "w2"}, {"c2"}, {kPads}), layer("Relu", {"c2"}, {"m"}, {}),
       layer("Concat", {"x", "half", "m"}, {"joined"}, {attribute("axis", 1)}),
       layer("Conv", {"joined", "w3"}, {"out"}, {}), layer("Conv", {"x", "w4"}, {"other"}, {})},
      {random_weights("w1", {32, 3, 3, 3}, 1), random_weights("w2", {16, 16, 3, 3}, 2),
       random_weights("w3", {24, 64, 1, 1}, 3), random_weights("w4", {8, 32, 1, 1}, 4),
       numbers("begin", 16), numbers("end", 32), numbers("axis", 1)},
      {1, 3, 20, 18},
      {{"out", {1, 24, 20, 18}}, {"other", {1, 8, 20, 18}}},
      13}));
}

// As squeeze-and-excite does: the mean has a step of its own.
TEST(Quantization, TheMeanOfAPictureIsNotReadWithThePicturesStep) {
  expect_near(onnx(TinyGraph{
      {layer("Conv", {"picture", "w1"}, {"c1"}, {kPads}), layer("Relu", {"c1"}, {"x"}, {}),
       layer("GlobalAveragePool", {"x"}, {"mean"}, {}), layer("Conv", {"mean", "w2"}, {"out"}, {}),
       layer("Conv", {"x", "w3"}, {"other"}, {})},
      {random_weights("w1", {32, 3, 3, 3}, 1), random_weights("w2", {8, 32, 1, 1}, 2),
       random_weights("w3", {8, 32, 1, 1}, 3)},
      {1, 3, 20, 18},
      {{"out", {1, 8, 1, 1}}, {"other", {1, 8, 20, 18}}},
      13}));
}

TEST(Quantization, NeedsInputsOfOneShape) {
  std::vector<Tensor> pictures = some_pictures();
  pictures.push_back(random_tensor({1, 3, 8, 8}));
  EXPECT_ERROR(calibrate_eight_bits(branched_graph(), {}, pictures),
               "8 bits were measured on inputs of 1x3x8x8, not 1x3x20x18");
  EXPECT_ERROR(calibrate_eight_bits(branched_graph(), {}, {}), "inputs to measure on");
}

TEST(Quantization, RangesAreOfOneNetworkAndOneShape) {
  const OnnxGraph graph = branched_graph();
  const ExecutorOptions options = in_eight_bits(graph, some_pictures());
  ExecutorOptions of_others = options;
  of_others.eight_bits->input = {1, 3, 8, 8};
  EXPECT_ERROR(Executor::create(graph, of_others),
               "8 bits were measured on inputs of 1x3x8x8, not 1x3x20x18");
  EXPECT_ERROR(Executor::create(widening_graph(), options),
               "nothing was measured of the layer \"narrow");
}

// One node may become several layers.
TEST(Quantization, LayersOfOneNodeHaveNamesOfTheirOwn) {
  Program program;
  program.values.resize(6);
  program.inputs = {0};
  program.layers = {{View{}, {0}, 1, "node"},
                    {View{}, {1}, 2, "other"},
                    {View{}, {2}, 3, "node"},
                    {View{}, {3}, 4, "node #2"},
                    {View{}, {4}, 5, ""}};
  EXPECT_THAT(names_of_layers(program),
              ::testing::ElementsAre("node", "other", "node #2", "node #2 #2", " #2"));
  const std::vector<ActivationRange> ranges{{0, 1}, {0, 2}, {-3, 3}, {0, 4}, {0, 5}, {0, 6}};
  const EightBitRanges named{{}, 1, named_ranges(program, ranges)};
  EXPECT_EQ(*ranges_of_values(program, named), ranges);
}

}  // namespace
}  // namespace roomwise::network
