#include "roomwise/network/vision/compact_network.h"

#include <gmock/gmock.h>

#include "roomwise/network/formats/onnx_writer.h"
#include "roomwise/network/testing/tiny_runs.h"

namespace roomwise::network {
namespace {

using namespace testing;

TEST(CompactNetwork, TakesAtMostFourMegabytes) {
  const auto file = write_onnx_graph(compact_network());
  ASSERT_OK(file);
  EXPECT_LT(file->size(), 4'000'000u);
  EXPECT_GT(file->size(), 2'500'000u) << "its weights are floats of 32 bits";
}

TEST(CompactNetwork, GivesScoresAndFeatures) {
  ExecutorOptions options;
  options.outputs = {"features", "logits"};
  CompactOptions compact;
  compact.classes = 7;
  compact.batch = GraphInput::kDynamic;
  const auto executor = Executor::create(compact_network(compact), options);
  ASSERT_OK(executor);
  const ModelCard card = compact_card();
  const Tensor pictures = random_tensor({2, 3, card.input_height_px, card.input_width_px});
  const auto outputs = (*executor)->run({&pictures, 1});
  ASSERT_OK(outputs);
  EXPECT_EQ((*outputs)[0].shape, (Shape{2, 256}));
  EXPECT_EQ((*outputs)[1].shape, (Shape{2, 7}));
}

TEST(CompactNetwork, GivesWhatOpenCvGives) {
  const OnnxGraph graph = compact_network();
  const auto file = write_onnx_graph(graph);
  ASSERT_OK(file);
  const auto executor = Executor::create(graph);
  ASSERT_OK(executor);
  const Tensor picture = random_tensor({1, 3, 128, 128});
  const auto outputs = (*executor)->run({&picture, 1});
  ASSERT_OK(outputs);
  EXPECT_LT(
      relative_error(outputs->front().values, OpenCvNetwork(as_by_pytorch(*file)).run(picture)),
      1e-4);
}

TEST(CompactNetwork, SameSeedSameWeights) {
  const auto weights = [](std::uint64_t seed) {
    CompactOptions options;
    options.weights.seed = seed;
    return compact_network(options).constants.at("last.conv.weight")->floats;
  };
  EXPECT_EQ(weights(1), weights(1));
  EXPECT_NE(weights(1), weights(2));
}

TEST(CompactNetwork, ItsCardNamesItsValues) {
  const OnnxGraph graph = compact_network();
  const ModelCard card = compact_card();
  EXPECT_EQ(graph.outputs, std::vector<std::string>{card.scores_output});
  EXPECT_THAT(card.features_outputs, ::testing::ElementsAre("features"));
  EXPECT_EQ(graph.inputs.front().shape, (Shape{1, 3, card.input_height_px, card.input_width_px}));
}

}  // namespace
}  // namespace roomwise::network
