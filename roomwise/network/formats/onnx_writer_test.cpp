#include "roomwise/network/formats/onnx_writer.h"

#include <gmock/gmock.h>

#include "roomwise/base/file.h"
#include "roomwise/network/graph/graph_builder.h"
#include "roomwise/network/testing/more_layers.h"
#include "roomwise/network/testing/tiny_runs.h"

namespace roomwise::network {
namespace {

using namespace testing;
using ::testing::HasSubstr;

void expect_same(const Constant& a, const Constant& b) {
  EXPECT_EQ(a.shape, b.shape);
  EXPECT_EQ(a.is_integer, b.is_integer);
  EXPECT_EQ(a.floats, b.floats);
  EXPECT_EQ(a.integers, b.integers);
}

void expect_same(const Node& a, const Node& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.operation, b.operation);
  EXPECT_EQ(a.domain, b.domain);
  EXPECT_EQ(a.inputs, b.inputs);
  EXPECT_EQ(a.outputs, b.outputs);
  ASSERT_EQ(a.attributes.size(), b.attributes.size()) << a.name;
  for (const auto& [name, one] : a.attributes) {
    const Attribute* other = b.find(name);
    ASSERT_NE(other, nullptr) << name;
    EXPECT_EQ(one.kind, other->kind) << name;
    EXPECT_EQ(one.integer, other->integer) << name;
    EXPECT_EQ(one.number, other->number) << name;
    EXPECT_EQ(one.text, other->text) << name;
    EXPECT_EQ(one.integers, other->integers) << name;
    EXPECT_EQ(one.numbers, other->numbers) << name;
    ASSERT_EQ(one.tensor == nullptr, other->tensor == nullptr) << name;
    if (one.tensor != nullptr) expect_same(*one.tensor, *other->tensor);
  }
}

void expect_same(const OnnxGraph& a, const OnnxGraph& b) {
  EXPECT_EQ(a.opset, b.opset);
  EXPECT_EQ(a.outputs, b.outputs);
  EXPECT_EQ(a.output_shapes, b.output_shapes);
  ASSERT_EQ(a.inputs.size(), b.inputs.size());
  for (std::size_t i = 0; i < a.inputs.size(); ++i) {
    EXPECT_EQ(a.inputs[i].name, b.inputs[i].name);
    EXPECT_EQ(a.inputs[i].shape, b.inputs[i].shape);
  }
  ASSERT_EQ(a.constants.size(), b.constants.size());
  for (const auto& [name, constant] : a.constants) {
    ASSERT_TRUE(b.constants.contains(name)) << name;
    expect_same(*constant, *b.constants.at(name));
  }
  ASSERT_EQ(a.nodes.size(), b.nodes.size());
  for (std::size_t i = 0; i < a.nodes.size(); ++i) expect_same(a.nodes[i], b.nodes[i]);
}

// A graph with attributes and tensors of every kind.
OnnxGraph graph_of_every_kind() {
  OnnxGraph graph;
  graph.opset = 13;
  graph.inputs = {{"picture", {GraphInput::kDynamic, 3, GraphInput::kDynamic, 5}}, {"any", {}}};
  graph.outputs = {"y", "z"};
  graph.output_shapes = {{"y", {2, GraphInput::kDynamic}}};
  auto floats = std::make_shared<Constant>();
  floats->shape = {2, 1};
  floats->floats = {-0.0F, 3.25e-20F};
  auto integers = std::make_shared<Constant>();
  integers->shape = {3};
  integers->is_integer = true;
  integers->integers = {-1, 0, std::int64_t{1} << 40};
  auto single = std::make_shared<Constant>();
  single->floats = {7};
  graph.constants = {{"floats", floats}, {"integers", integers}, {"single", single}};
  Node node{"n", "Anything", "some.domain", {"picture", "", "floats"}, {"y", "z"}, {}};
  node.attributes["integer"] = Attribute(std::int64_t{-5});
  node.attributes["number"] = Attribute(0.1F);
  node.attributes["text"] = Attribute(std::string("words"));
  node.attributes["integers"] = Attribute(std::vector<std::int64_t>{3, -1});
  node.attributes["no integers"] = Attribute(std::vector<std::int64_t>{});
  Attribute numbers;
  numbers.kind = Attribute::Kind::kNumbers;
  numbers.numbers = {1, 2.5F};
  node.attributes["numbers"] = numbers;
  Attribute tensor;
  tensor.kind = Attribute::Kind::kTensor;
  tensor.tensor = integers;
  node.attributes["tensor"] = tensor;
  graph.nodes.push_back(node);
  return graph;
}

TEST(OnnxWriter, IsReadBackToTheBit) {
  const OnnxGraph graph = graph_of_every_kind();
  const auto bytes = write_onnx_graph(graph);
  ASSERT_OK(bytes);
  const auto read = read_onnx_graph(*bytes);
  ASSERT_OK(read);
  expect_same(graph, *read);
  EXPECT_EQ(*write_onnx_graph(*read), *bytes);
}

// As onnxruntime asks for.
TEST(OnnxWriter, IndicesAreDeclaredAsWholeNumbers) {
  OnnxGraph graph;
  graph.opset = 13;
  graph.inputs = {{"x", {1, 3}}};
  graph.outputs = {"a", "b"};
  graph.nodes = {{"", "Relu", "", {"x"}, {"a"}, {}}, {"", "ArgMax", "", {"x"}, {"b"}, {}}};
  const Bytes bytes = write_onnx_graph(graph).value();
  const std::string text(bytes.begin(), bytes.end());
  // Name, type of a tensor, type of its elements: TensorProto.DataType.
  EXPECT_THAT(text, HasSubstr("\x0A\x01"
                              "a\x12\x04\x0A\x02\x08\x01"));
  EXPECT_THAT(text, HasSubstr("\x0A\x01"
                              "b\x12\x04\x0A\x02\x08\x07"));
}

TEST(OnnxWriter, RefusesWhatNoFileMayBe) {
  OnnxGraph graph = graph_of_every_kind();
  graph.opset = 9;
  EXPECT_ERROR(write_onnx_graph(graph), "opset 9; 10 to 17");
  graph = graph_of_every_kind();
  graph.outputs.clear();
  EXPECT_ERROR(write_onnx_graph(graph), "2 inputs and 0 outputs");
  graph = graph_of_every_kind();
  auto torn = std::make_shared<Constant>();
  torn->shape = {2, 2};
  torn->floats = {1, 2, 3};
  graph.constants["floats"] = torn;
  EXPECT_ERROR(write_onnx_graph(graph), "\"floats\" has 3 values, not those of its shape 2x2");
  graph = graph_of_every_kind();
  graph.nodes[0].attributes["tensor"].tensor.reset();
  EXPECT_ERROR(write_onnx_graph(graph), "\"tensor\" of node \"n\" lacks its tensor");
}

// All that the builder knows, in one network, but for what OpenCV 4.6 does not take: relu6 (it
// wants the limits as attributes, as they were before opset 11) and products that repeat sizes
// of 1.
OnnxGraph all_layers() {
  GraphBuilder builder({7, false});
  auto x = builder.input("picture", {1, 3, 17, 13});
  x = builder.convolution(x, "stem.conv", {12, {3, 3}, {2, 1}, {1, 0}});
  x = testing::hard_swish(builder, builder.batch_norm(x, "stem.bn", 0.001F), "stem");
  auto a = builder.convolution(x, "a.conv", {12, {1, 1}, {1, 1}, {0, 0}, 3, true});
  a = builder.relu(a, "a");
  auto gate = builder.global_average_pool(a, "gate.mean");
  gate = testing::hard_sigmoid(builder, builder.convolution(gate, "gate.conv", {12}), "gate");
  const auto flat_gate = builder.flatten(gate, "gate.flat");
  a = builder.add(a, x, "sum");
  const auto b = builder.average_pool(builder.relu(a, "b.relu"), "b", {{3, 3}, {1, 1}, {1, 1}});
  const auto c =
      builder.max_pool(testing::sigmoid(builder, x, "c.sigmoid"), "c", {{3, 3}, {1, 1}, {1, 1}});
  x = builder.concat(std::array{a, b, c}, "joined");
  EXPECT_EQ(builder.shape(x), (Shape{1, 36, 9, 11}));
  x = builder.flatten(builder.max_pool(x, "pool", {{3, 3}, {2, 2}, {0, 0}}), "flat");
  x = builder.concat(std::array{x, flat_gate}, "with gate");
  x = builder.linear(builder.dropout(x, "dropout", 0.2F), "fc", 10);
  builder.output(testing::softmax(builder, x, "scores"));
  return builder.take();
}

TEST(OnnxWriter, OpenCvReadsItToo) {
  const OnnxGraph graph = all_layers();
  const auto bytes = write_onnx_graph(graph);
  ASSERT_OK(bytes);
  const auto read = read_onnx_graph(*bytes);
  ASSERT_OK(read);
  expect_same(graph, *read);
  const Tensor input = random_tensor({1, 3, 17, 13});
  const auto executor = Executor::create(*read);
  ASSERT_OK(executor);
  const auto outputs = (*executor)->run({&input, 1});
  ASSERT_OK(outputs);
  EXPECT_LT(
      relative_error(outputs->front().values, OpenCvNetwork(as_by_pytorch(*bytes)).run(input)),
      1e-5);
}

TEST(OnnxWriter, KeepsProductsThatRepeatSizes) {
  GraphBuilder builder;
  const auto picture = builder.input("x", {1, 2, 1, 2});
  builder.output(
      testing::multiply(builder, picture, builder.global_average_pool(picture, "mean"), "gated"));
  const auto bytes = write_onnx_graph(builder.take());
  ASSERT_OK(bytes);
  auto graph = read_onnx_graph(*bytes);
  ASSERT_OK(graph);
  const auto executor = Executor::create(std::move(*graph));
  ASSERT_OK(executor);
  const Tensor input{{1, 2, 1, 2}, {1, 3, -1, 5}};
  const auto outputs = (*executor)->run({&input, 1});
  ASSERT_OK(outputs);
  EXPECT_THAT(outputs->front().values, ::testing::ElementsAre(2, 6, -2, 10));
}

TEST(OnnxWriter, KeepsTheLimitsOfRelu6) {
  GraphBuilder builder;
  builder.output(testing::relu6(builder, builder.input("x", {1, 4}), "clipped"));
  const auto bytes = write_onnx_graph(builder.take());
  ASSERT_OK(bytes);
  auto graph = read_onnx_graph(*bytes);
  ASSERT_OK(graph);
  const auto executor = Executor::create(std::move(*graph));
  ASSERT_OK(executor);
  const Tensor input{{1, 4}, {-2, 3, 6, 9}};
  const auto outputs = (*executor)->run({&input, 1});
  ASSERT_OK(outputs);
  EXPECT_THAT(outputs->front().values, ::testing::ElementsAre(0, 3, 6, 6));
}

class WrittenAnew : public ::testing::TestWithParam<const char*> {};

// The networks of ROOMWISE_MODELS, written anew.
TEST_P(WrittenAnew, IsTheSameNetwork) {
  const auto file = roomwise::testing::find_model(GetParam());
  ROOMWISE_REQUIRE_FILE(file);
  const auto given = read_file(*file);
  ASSERT_OK(given);
  const auto graph = read_onnx_graph(*given);
  ASSERT_OK(graph);
  const auto bytes = write_onnx_graph(*graph);
  ASSERT_OK(bytes);
  const auto read = read_onnx_graph(*bytes);
  ASSERT_OK(read);
  expect_same(*graph, *read);
  const Tensor input = random_tensor(graph->inputs[0].shape);
  EXPECT_EQ(OpenCvNetwork(*bytes).run(input), OpenCvNetwork(*given).run(input));
}

INSTANTIATE_TEST_SUITE_P(Models, WrittenAnew,
                         ::testing::Values("mobilenet-v2-imagenet.onnx", "nanodet-plus-m-416.onnx",
                                           "inception-2015-12-05-trunk.onnx"),
                         [](const auto& each) {
                           std::string name = each.param;
                           std::erase_if(name, [](char c) { return std::isalnum(c) == 0; });
                           return name;
                         });

}  // namespace
}  // namespace roomwise::network
