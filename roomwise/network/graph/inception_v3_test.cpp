#include "roomwise/network/graph/inception_v3.h"

#include <gmock/gmock.h>

#include "roomwise/base/file.h"
#include "roomwise/network/formats/onnx_writer.h"
#include "roomwise/network/formats/safetensors.h"
#include "roomwise/network/testing/tiny_runs.h"
#include "roomwise/network/vision/onnx_classifier.h"

namespace roomwise::network {
namespace {

using namespace testing;

std::size_t learned_numbers(const OnnxGraph& graph) {
  std::size_t numbers = 0;
  for (const std::string& name : parameters_of(graph)) {
    // PyTorch counts the statistics of batch norms as buffers, not as parameters.
    if (!name.ends_with(".running_mean") && !name.ends_with(".running_var"))
      numbers += graph.constants.at(name)->size();
  }
  return numbers;
}

// torchvision's documentation of inception_v3 says 27,161,264 with the auxiliary head.
TEST(InceptionV3, HasAsManyParametersAsTorchvisions) {
  EXPECT_EQ(learned_numbers(inception_v3()), 23'834'568u);
  InceptionOptions options;
  options.has_auxiliary_head = true;
  EXPECT_EQ(learned_numbers(inception_v3(options)), 27'161'264u);
}

TEST(InceptionV3, NamesParametersAsTorchvisionDoes) {
  InceptionOptions options;
  options.has_auxiliary_head = true;
  const OnnxGraph graph = inception_v3(options);
  const auto shape = [&](const char* name) { return graph.constants.at(name)->shape; };
  EXPECT_EQ(shape("Conv2d_1a_3x3.conv.weight"), (Shape{32, 3, 3, 3}));
  EXPECT_EQ(shape("Conv2d_4a_3x3.bn.running_var"), (Shape{192}));
  EXPECT_EQ(shape("Mixed_5b.branch1x1.conv.weight"), (Shape{64, 192, 1, 1}));
  EXPECT_EQ(shape("Mixed_5d.branch5x5_2.conv.weight"), (Shape{64, 48, 5, 5}));
  EXPECT_EQ(shape("Mixed_6a.branch3x3dbl_3.conv.weight"), (Shape{96, 96, 3, 3}));
  EXPECT_EQ(shape("Mixed_6c.branch7x7dbl_2.conv.weight"), (Shape{160, 160, 7, 1}));
  EXPECT_EQ(shape("Mixed_6e.branch7x7_2.conv.weight"), (Shape{192, 192, 1, 7}));
  EXPECT_EQ(shape("Mixed_7a.branch7x7x3_4.conv.weight"), (Shape{192, 192, 3, 3}));
  EXPECT_EQ(shape("Mixed_7c.branch3x3dbl_3b.conv.weight"), (Shape{384, 384, 3, 1}));
  EXPECT_EQ(shape("Mixed_7b.branch_pool.bn.bias"), (Shape{192}));
  EXPECT_EQ(shape("AuxLogits.conv1.conv.weight"), (Shape{768, 128, 5, 5}));
  EXPECT_EQ(shape("AuxLogits.fc.weight"), (Shape{1000, 768}));
  EXPECT_EQ(shape("fc.weight"), (Shape{1000, 2048}));
  EXPECT_EQ(shape("fc.bias"), (Shape{1000}));
  // 96 convolutions with four numbers a channel behind each, and two linear layers.
  EXPECT_EQ(parameters_of(graph).size(), 96u * 5 + 4);
}

double root_mean_square(const Tensor& tensor) {
  double sum = 0;
  for (const float value : tensor.values) sum += static_cast<double>(value) * value;
  return std::sqrt(sum / static_cast<double>(tensor.values.size()));
}

TEST(InceptionV3, ValuesStayOfOrderOneFromBlockToBlock) {
  ExecutorOptions options;
  options.outputs = {"maxpool2", "Mixed_5d", "Mixed_6a", "Mixed_6e", "Mixed_7c", "features", "fc"};
  const auto executor = Executor::create(inception_v3(), options);
  ASSERT_OK(executor);
  const Tensor picture = random_tensor({1, 3, 299, 299});
  const auto outputs = (*executor)->run({&picture, 1});
  ASSERT_OK(outputs);
  for (std::size_t i = 0; i < outputs->size(); ++i) {
    EXPECT_GT(root_mean_square((*outputs)[i]), 0.1) << options.outputs[i];
    EXPECT_LT(root_mean_square((*outputs)[i]), 10) << options.outputs[i];
  }
  EXPECT_EQ((*outputs)[1].shape, (Shape{1, 288, 35, 35}));
  EXPECT_EQ((*outputs)[3].shape, (Shape{1, 768, 17, 17}));
  EXPECT_EQ((*outputs)[4].shape, (Shape{1, 2048, 8, 8}));
  EXPECT_EQ((*outputs)[5].shape, (Shape{1, 2048}));
}

TEST(InceptionV3, GivesWhatOpenCvGives) {
  InceptionOptions options;
  options.classes = 7;
  const OnnxGraph graph = inception_v3(options);
  const auto file = write_onnx_graph(graph);
  ASSERT_OK(file);
  const auto executor = Executor::create(graph);
  ASSERT_OK(executor);
  const Tensor picture = random_tensor({1, 3, 299, 299});
  const auto outputs = (*executor)->run({&picture, 1});
  ASSERT_OK(outputs);
  EXPECT_LT(
      relative_error(outputs->front().values, OpenCvNetwork(as_by_pytorch(*file)).run(picture)),
      1e-4);
}

// As torchvision's file would be: weights alone, a card beside them, labels with a class too many.
TEST(InceptionV3, IsLoadedFromWeightsAlone) {
  const roomwise::testing::ScratchFolder folder;
  InceptionOptions options;
  options.classes = 3;
  options.has_auxiliary_head = true;
  const OnnxGraph graph = inception_v3(options);
  Weights weights;
  for (const std::string& name : parameters_of(graph)) weights[name] = graph.constants.at(name);
  ASSERT_OK(write_file(folder / "mine.safetensors", write_safetensors(weights)));
  ASSERT_OK(write_file(folder / "labels.txt", std::string_view("background\none\ntwo\nthree\n")));
  const std::string card = R"({"input": {"width": 299, "height": 299}, "labels": "labels.txt",
      "mean": [127.5, 127.5, 127.5], "scale": [0.0078, 0.0078, 0.0078],
      "outputs": {"features": "features", "scores": "fc", "softmax": true})";
  ASSERT_OK(write_file(folder / "mine.card.json", std::string_view(card + "}")));
  EXPECT_ERROR(OnnxClassifier::load(folder / "mine.safetensors"), "say in its card of which");
  ASSERT_OK(write_file(
      folder / "mine.card.json",
      std::string_view(card + R"(, "first_label": 1, "architecture": "inception-v3"})")));
  const auto classifier = OnnxClassifier::load(folder / "mine.safetensors");
  ASSERT_OK(classifier);
  EXPECT_THAT((*classifier)->labels(), ::testing::ElementsAre("one", "two", "three"));
  EXPECT_EQ((*classifier)->feature_size(), 2048u);
}

TEST(InceptionV3, GivesBothHeadsForAnyBatch) {
  InceptionOptions options;
  options.classes = 5;
  options.has_auxiliary_head = true;
  options.batch = GraphInput::kDynamic;
  const auto executor = Executor::create(inception_v3(options));
  ASSERT_OK(executor);
  const Tensor pictures = random_tensor({2, 3, 299, 299});
  const auto outputs = (*executor)->run({&pictures, 1});
  ASSERT_OK(outputs);
  EXPECT_EQ((*outputs)[0].shape, (Shape{2, 5}));
  EXPECT_EQ((*outputs)[1].shape, (Shape{2, 5}));
}

TEST(GraphBuilder, SameSeedSameWeights) {
  const auto weights = [](std::uint64_t seed, std::int64_t classes) {
    InceptionOptions options;
    options.classes = classes;
    options.weights.seed = seed;
    return inception_v3(options).constants.at("Mixed_7c.branch1x1.conv.weight")->floats;
  };
  EXPECT_EQ(weights(3, 5), weights(3, 6));
  EXPECT_NE(weights(3, 5), weights(4, 5));
}

TEST(GraphBuilder, RefusesWhatDoesNotFit) {
  GraphBuilder builder;
  const auto picture = builder.input("picture", {1, 3, 8, 8});
  const auto small = builder.convolution(picture, "small", {4, {3, 3}, {2, 2}});
  EXPECT_THROW(builder.convolution(picture, "small", {4}), std::invalid_argument);
  EXPECT_THROW(builder.convolution(small, "huge", {4, {5, 5}}), std::invalid_argument);
  EXPECT_THROW(builder.convolution(picture, "groups", {4, {1, 1}, {1, 1}, {0, 0}, 2}),
               std::invalid_argument);
  EXPECT_THROW(builder.concat(std::array{picture, small}, "joined"), std::invalid_argument);
  EXPECT_THROW(builder.relu("nothing", "relu"), std::invalid_argument);
}

TEST(GraphBuilder, NeutralNormsDoNothing) {
  GraphBuilder builder({1, true});
  builder.batch_norm(builder.input("picture", {1, 3, 8, 8}), "bn");
  const OnnxGraph graph = builder.take();
  EXPECT_EQ(graph.constants.at("bn.weight")->floats, std::vector<float>(3, 1));
  EXPECT_EQ(graph.constants.at("bn.bias")->floats, std::vector<float>(3, 0));
  EXPECT_EQ(graph.constants.at("bn.running_var")->floats, std::vector<float>(3, 1));
}

}  // namespace
}  // namespace roomwise::network
