#include "laboratory/training/trainable_graph.h"

#include <ATen/Functions.h>
#include <ATen/core/grad_mode.h>
#include <gmock/gmock.h>

#include "laboratory/training/testing/small_networks.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/network/formats/network_file.h"
#include "roomwise/network/graph/inception_v3.h"
#include "roomwise/network/testing/tiny_runs.h"

namespace roomwise::training {
namespace {

using network::testing::random_tensor;
using network::testing::relative_error;
using training::testing::node;
using training::testing::small_network;

at::Tensor batch_of(const network::Tensor& tensor) {
  return tensor_of(network::Constant{tensor.shape, false, tensor.values, {}});
}

// libtorch's output beside Executor's for random numbers.
double difference(const network::OnnxGraph& graph, const network::Shape& shape) {
  const at::NoGradGuard no_gradient;
  const network::Tensor input = random_tensor(shape);
  const auto trainable = TrainableGraph::create(graph);
  const auto executor = network::Executor::create(graph);
  if (!trainable || !executor) {
    ADD_FAILURE() << (trainable ? executor.error() : trainable.error()).message;
    return 1;
  }
  const auto ours = (*executor)->run({&input, 1});
  const auto theirs = trainable->forward(batch_of(input), false);
  if (!ours || !theirs) {
    ADD_FAILURE() << (ours ? theirs.error() : ours.error()).message;
    return 1;
  }
  return relative_error(constant_of(theirs->front()).floats, ours->front().values);
}

TEST(TrainableGraph, GivesWhatTheExecutorGives) {
  EXPECT_LT(difference(small_network(), {1, 3, 16, 16}), 1e-5);
}

TEST(TrainableGraph, GivesWhatTheExecutorGivesForRealNetworks) {
  for (const char* name : {"mobilenet-v2-imagenet.onnx", "inception-2015-12-05-trunk.onnx"}) {
    const auto path = roomwise::testing::find_model(name);
    ROOMWISE_REQUIRE_FILE(path);
    const auto file = network::read_network_file(*path, std::nullopt);
    ASSERT_OK(file);
    EXPECT_LT(difference(file->graph, file->graph.inputs.front().shape), 1e-4) << name;
  }
}

TEST(TrainableGraph, GivesWhatTheExecutorGivesForInception) {
  network::InceptionOptions options;
  options.classes = 10;
  options.side_px = 75;
  EXPECT_LT(difference(network::inception_v3(options), {1, 3, 75, 75}), 1e-4);
}

TEST(TrainableGraph, TakesBatches) {
  const at::NoGradGuard no_gradient;
  const auto graph = TrainableGraph::create(small_network());
  ASSERT_OK(graph);
  const at::Tensor batch = batch_of(random_tensor({3, 3, 16, 16}));
  const auto together = graph->forward(batch, false);
  const auto alone = graph->forward(batch.slice(0, 2, 3), false);
  ASSERT_OK(together);
  ASSERT_OK(alone);
  EXPECT_TRUE(at::allclose(together->front().slice(0, 2, 3), alone->front(), 1e-5, 1e-6));
}

TEST(TrainableGraph, FindsGradientsAsDifferencesDo) {
  const auto graph = TrainableGraph::create(small_network(false));
  ASSERT_OK(graph);
  const at::Tensor batch = batch_of(random_tensor({2, 3, 16, 16}));
  const auto loss = [&] {
    const auto outputs = graph->forward(batch, true);
    EXPECT_OK(outputs);
    return outputs->front().to(at::kDouble).square().sum();
  };
  loss().backward();
  for (const GraphTensor& parameter : graph->parameters()) {
    const at::NoGradGuard no_gradient;
    auto& first = *parameter.tensor.data_ptr<float>();
    const float step = 1e-3F, before = first;
    first = before + step;
    const double above = loss().item<double>();
    first = before - step;
    const double below = loss().item<double>();
    first = before;
    const double found = parameter.tensor.grad().flatten()[0].item<double>();
    EXPECT_NEAR(found, (above - below) / (2 * static_cast<double>(step)),
                0.03 * std::abs(found) + 0.02)
        << parameter.name;
  }
}

TEST(TrainableGraph, FreezesWhatComesBefore) {
  const auto graph = TrainableGraph::create(small_network(), {.outputs = {}, .from = "second"});
  ASSERT_OK(graph);
  const network::OnnxGraph before = graph->graph();
  const auto outputs = graph->forward(batch_of(random_tensor({4, 3, 16, 16})), true);
  ASSERT_OK(outputs);
  outputs->front().sum().backward();
  for (const GraphTensor& parameter : graph->parameters()) {
    const bool is_second = parameter.name.starts_with("second");
    EXPECT_EQ(parameter.trained, is_second) << parameter.name;
    EXPECT_EQ(parameter.tensor.grad().defined(), is_second) << parameter.name;
  }
  const network::OnnxGraph after = graph->graph();
  for (const char* statistic : {"first_mean", "first_variance"})
    EXPECT_EQ(after.constants.at(statistic)->floats, before.constants.at(statistic)->floats);
  for (const char* statistic : {"second_mean", "second_variance"})
    EXPECT_NE(after.constants.at(statistic)->floats, before.constants.at(statistic)->floats);
}

TEST(TrainableGraph, TrainsConstantsBehindNodes) {
  network::OnnxGraph graph = small_network(false);
  // As some exporters write them: the weights as a node, and the same weights by another name.
  network::Node weights = node("Constant", {}, "first_weights");
  weights.attributes["value"].tensor = graph.constants.at("first_weights");
  graph.constants.erase("first_weights");
  graph.nodes.insert(graph.nodes.begin(), {weights, node("Identity", {"first_weights"}, "same")});
  graph.nodes[2].inputs[1] = "same";
  const auto trainable = TrainableGraph::create(graph);
  ASSERT_OK(trainable);
  ASSERT_EQ(trainable->parameters().size(), 4);
  EXPECT_EQ(trainable->parameters().front().name, "first_weights");
  EXPECT_LT(difference(graph, {1, 3, 16, 16}), 1e-5);
}

// A file for single pictures says 1 of the batch, but also of constants, where it means 1.
TEST(TrainableGraph, ReshapesBatchesButNotConstants) {
  network::OnnxGraph graph;
  graph.opset = 13;
  graph.inputs = {{"picture", {1, 3, 2, 2}}};
  graph.constants["table"] = testing::random_constant({4, 3}, 1, 0, 2);
  graph.constants["sizes"] =
      std::make_shared<const network::Constant>(network::Constant{{2}, true, {}, {1, 12}});
  graph.nodes = {node("Reshape", {"picture", "sizes"}, "flat"),
                 node("Reshape", {"table", "sizes"}, "row"), node("Add", {"flat", "row"}, "sum")};
  graph.outputs = {"sum"};
  const auto trainable = TrainableGraph::create(graph);
  ASSERT_OK(trainable);
  const auto sums = trainable->forward(at::zeros({2, 3, 2, 2}), false);
  ASSERT_OK(sums);
  ASSERT_EQ(sums->front().sizes(), (std::vector<std::int64_t>{2, 12}));
  const auto& table = graph.constants.at("table")->floats;
  for (const std::int64_t i : {0, 1}) EXPECT_EQ(constant_of(sums->front()[i]).floats, table);
}

TEST(TrainableGraph, SaysWhatItCannotTrain) {
  network::OnnxGraph graph = small_network();
  graph.nodes.push_back(node("LSTM", {"features"}, "state"));
  graph.outputs = {"state"};
  EXPECT_ERROR(TrainableGraph::create(graph), "node \"state_node\" (LSTM, opset 13): the operator");
  graph = small_network();
  EXPECT_ERROR(TrainableGraph::create(graph, {.outputs = {}, .from = "third"}), "no node or block");
  EXPECT_ERROR(TrainableGraph::create(graph, {.outputs = {"scores"}, .from = ""}), "no output");
  const auto trainable = TrainableGraph::create(graph);
  ASSERT_OK(trainable);
  EXPECT_ERROR(trainable->forward(batch_of(random_tensor({1, 4, 16, 16})), false),
               "node \"first_conv_node\" (Conv, opset 13)");
}

}  // namespace
}  // namespace roomwise::training
