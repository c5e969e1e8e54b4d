#include "roomwise/network/vision/dense_classifier.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>

#include "roomwise/network/testing/tiny_runs.h"
#include "roomwise/network/vision/onnx_classifier.h"

namespace roomwise::network {
namespace {

using namespace testing;
using ::testing::ElementsAre;
using ::testing::FloatNear;
using ::testing::Pointwise;

// Two scores of two channels at 1 x 3 places: 10 a + b + 1 and a - b + 2.
const std::vector<float> kHeadWeights{10, 1, 1, -1};  // the same either way round
const Tensor kThreePlaces{{1, 2, 1, 3}, {1, 2, 3, 4, 5, 6}};

OnnxGraph graph_with_head(const std::vector<std::string>& head,
                          std::vector<std::int64_t> weights_shape,
                          const std::vector<float>& weights = kHeadWeights) {
  std::vector<std::string> nodes{layer("Identity", {"picture"}, {"map"}),
                                 layer("GlobalAveragePool", {"map"}, {"pooled"})};
  nodes.insert(nodes.end(), head.begin(), head.end());
  const std::string file = onnx(
      TinyGraph{nodes,
                {tensor("w", weights_shape, weights), tensor("b", {2}, std::vector<float>{1, 2})},
                {1, 2, 1, 3},
                {{"scores", {}}},
                12});
  return read_onnx_graph(bytes_of(file)).value();
}

std::vector<float> run_graph(OnnxGraph graph, const Tensor& input) {
  const auto executor = Executor::create(std::move(graph));
  EXPECT_OK(executor);
  auto outputs = (*executor)->run({&input, 1});
  EXPECT_OK(outputs);
  return outputs->front().values;
}

TEST(DenseGraph, PutsTheLastLayersOnEachCell) {
  const std::string flatten = layer("Flatten", {"pooled"}, {"flat"});
  const std::vector<OnnxGraph> graphs{
      graph_with_head(
          {flatten, layer("Gemm", {"flat", "w", "b"}, {"scores"}, {attribute("transB", 1)})},
          {2, 2}),
      graph_with_head({flatten, layer("Gemm", {"flat", "w", "b"}, {"scores"})}, {2, 2}),
      graph_with_head({layer("Conv", {"pooled", "w", "b"}, {"c"}), layer("Identity", {"c"}, {"i"}),
                       layer("Flatten", {"i"}, {"f"}),
                       layer("Softmax", {"f"}, {"scores"}, {attribute("axis", 1)})},
                      {2, 2, 1, 1})};
  for (const OnnxGraph& graph : graphs) {
    const auto dense = dense_graph(graph, "scores");
    ASSERT_OK(dense);
    EXPECT_THAT(run_graph(*dense, kThreePlaces), ElementsAre(15, 26, 37, -1, -1, -1));
    // And of any size.
    const Tensor tall{{1, 2, 2, 1}, {1, 2, 4, 5}};
    EXPECT_THAT(run_graph(*dense, tall), ElementsAre(15, 26, -1, -1));
  }
  // By the node's name, too.
  EXPECT_OK(dense_graph(graphs[0], "scores_node"));
}

TEST(DenseGraph, WeightsOfAProductStandAsInputsByOutputs) {
  const auto dense = dense_graph(graph_with_head({layer("Flatten", {"pooled"}, {"flat"}),
                                                  layer("MatMul", {"flat", "w"}, {"scores"})},
                                                 {2, 2}, {10, 3, 1, -1}),
                                 "scores");
  ASSERT_OK(dense);
  EXPECT_THAT(run_graph(*dense, kThreePlaces), ElementsAre(14, 25, 36, -1, 1, 3));
}

TEST(DenseGraph, SaysWhyANetworkHasNone) {
  const std::string flatten = layer("Flatten", {"pooled"}, {"flat"});
  EXPECT_ERROR(
      dense_graph(graph_with_head({layer("Flatten", {"pooled"}, {"scores"})}, {2, 2}), "scores"),
      "GlobalAveragePool");
  EXPECT_ERROR(dense_graph(graph_with_head({flatten, layer("Gemm", {"flat", "w", "b"}, {"g"}),
                                            layer("Relu", {"g"}, {"scores"})},
                                           {2, 2}),
                           "scores"),
               "scores_node (Relu) comes after it");
  EXPECT_ERROR(
      dense_graph(graph_with_head({flatten, layer("Gemm", {"flat", "flat"}, {"scores"})}, {2, 2}),
                  "scores"),
      "has no fixed weights");
  EXPECT_ERROR(dense_graph(graph_with_head({layer("Flatten", {"map"}, {"f"}),
                                            layer("Gemm", {"f", "w"}, {"scores"})},
                                           {6, 2}, std::vector<float>(12, 1)),
                           "scores"),
               "nothing gives \"picture\"");
  EXPECT_ERROR(
      dense_graph(graph_with_head({layer("Flatten", {"pooled"}, {"scores"})}, {2, 2}), "other"),
      "nothing gives \"other\"");
}

// As damaged files have them; the graph has not been checked yet.
TEST(DenseGraph, OfNodesWithoutInputsOrInACircleIsRefused) {
  OnnxGraph graph = graph_with_head({layer("Identity", {"pooled"}, {"scores"})}, {2, 2});
  Node& last = graph.nodes.back();
  last.inputs = {"scores"};
  EXPECT_ERROR(dense_graph(graph, "scores"), "in a circle");
  last.inputs.clear();
  EXPECT_ERROR(dense_graph(graph, "scores"), "has no input");
  last.outputs.clear();
  EXPECT_ERROR(dense_graph(graph, last.name), "nothing gives");
}

const std::filesystem::path kCompactFile =
    std::filesystem::path(ROOMWISE_MODELS_FOLDER) / "roomwise-compact-2.onnx";

// A picture with something in it: stripes and a gradient.
image::ColorImage striped(int width, int height) {
  image::ColorImage picture(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      picture.at(x, y) = {static_cast<std::uint8_t>(255 * x / width),
                          static_cast<std::uint8_t>(y / 9 % 2 == 0 ? 200 : 40),
                          static_cast<std::uint8_t>(255 * y / height)};
    }
  }
  return picture;
}

// At the size that the classifier takes, what the mean of the cells says is what it says.
void expect_mean_is_whole(const std::filesystem::path& weights, std::size_t cells) {
  const auto whole = OnnxClassifier::load(weights);
  ASSERT_OK(whole);
  const ModelCard& card = (*whole)->card();
  const auto dense = DenseClassifier::load(
      weights, DenseClassifier::InputSize{card.input_width_px, card.input_height_px});
  ASSERT_OK(dense);
  EXPECT_EQ((*dense)->fingerprint(), (*whole)->fingerprint());
  const image::ColorImage picture = striped(320, 240);
  const auto map = (*dense)->look(picture);
  ASSERT_OK(map);
  ASSERT_EQ(static_cast<std::size_t>(map->columns * map->rows), cells);
  std::vector<float> mean(map->labels, 0);
  for (int row = 0; row < map->rows; ++row) {
    for (int column = 0; column < map->columns; ++column) {
      const auto cell = map->at(column, row);
      for (std::size_t label = 0; label < mean.size(); ++label)
        mean[label] += cell[label] / static_cast<float>(cells);
    }
  }
  const auto prediction = (*whole)->predict(picture);
  ASSERT_OK(prediction);
  EXPECT_THAT(softmax(mean), Pointwise(FloatNear(1e-4F), prediction->scores));
  EXPECT_GT(*std::ranges::max_element(prediction->scores), 0.02F) << "it says something";
  const auto first = map->at(0, 0), last = map->at(map->columns - 1, map->rows - 1);
  EXPECT_FALSE(std::ranges::equal(first, last)) << "cells differ";
}

TEST(DenseClassifier, TheMeanOfItsCellsIsWhatTheWholePictureSays) {
  expect_mean_is_whole(kCompactFile, 16);
}

TEST(DenseClassifier, TheMeanOfItsCellsIsWhatMobileNetSays) {
  const auto weights = roomwise::testing::find_model("mobilenet-v2-imagenet.onnx");
  ROOMWISE_REQUIRE_FILE(weights);
  expect_mean_is_whole(*weights, 49);
}

TEST(DenseClassifier, LooksAtMoreCellsThanTheClassifier) {
  const auto dense = DenseClassifier::load(kCompactFile);
  ASSERT_OK(dense);
  EXPECT_EQ((*dense)->card().input_width_px, 352);
  EXPECT_EQ((*dense)->card().input_height_px, 256);
  const auto map = (*dense)->look(striped(640, 480));
  ASSERT_OK(map);
  EXPECT_EQ(map->columns, 11);
  EXPECT_EQ(map->rows, 8);
  EXPECT_ERROR((*dense)->look({}), "has no pixels");
  ModelCard card;
  const auto size_for = [&](int side_px) {
    card.input_width_px = card.input_height_px = side_px;
    const auto size = DenseClassifier::usual_size(card);
    return std::pair(size.width_px, size.height_px);
  };
  EXPECT_EQ(size_for(224), std::pair(352, 256));
  EXPECT_EQ(size_for(128), std::pair(352, 256)) << "fewer cells would be too large";
  EXPECT_EQ(size_for(448), std::pair(704, 512));
}

TEST(DenseClassifier, TakesNetworksThatNameThingsOnly) {
  const auto trunk = roomwise::testing::find_model("inception-2015-12-05-trunk.onnx");
  ROOMWISE_REQUIRE_FILE(trunk);
  EXPECT_ERROR(DenseClassifier::load(*trunk), "is no network that names what whole pictures show");
}

}  // namespace
}  // namespace roomwise::network
