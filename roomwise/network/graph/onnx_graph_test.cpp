#include "roomwise/network/graph/onnx_graph.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "roomwise/network/testing/tiny_runs.h"

namespace roomwise::network {
namespace {

using namespace testing;
using roomwise::testing::field;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TinyGraph small_graph() {
  return {{layer("Conv", {"picture", "w", "b"}, {"c"}, {attribute("pads", {1, 1, 1, 1})}),
           layer("LeakyRelu", {"c"}, {"r"}, {attribute("alpha", 0.25F)}),
           layer("Reshape", {"r", "shape"}, {"out"})},
          {random_weights("w", {2, 3, 3, 3}, 1), random_weights("b", {2}, 2),
           tensor("shape", {2}, std::vector<std::int64_t>{1, -1})},
          {1, 3, 4, 5},
          {{"out", {1, 40}}}};
}

TEST(OnnxGraph, IsReadWhole) {
  const std::string file = onnx(small_graph());
  const auto graph = read_onnx_graph(bytes_of(file));
  ASSERT_OK(graph);
  EXPECT_EQ(graph->opset, 11);
  ASSERT_EQ(graph->nodes.size(), 3u);
  const Node& convolution = graph->nodes[0];
  EXPECT_EQ(convolution.name, "c_node");
  EXPECT_EQ(convolution.operation, "Conv");
  EXPECT_THAT(convolution.inputs, ElementsAre("picture", "w", "b"));
  EXPECT_THAT(convolution.outputs, ElementsAre("c"));
  EXPECT_THAT(convolution.integers("pads", {}), ElementsAre(1, 1, 1, 1));
  EXPECT_THAT(convolution.integers("strides", {7}), ElementsAre(7));
  EXPECT_FLOAT_EQ(graph->nodes[1].number("alpha", 0), 0.25F);
  ASSERT_EQ(graph->inputs.size(), 1u);
  EXPECT_EQ(graph->inputs[0].name, "picture");
  EXPECT_THAT(graph->inputs[0].shape, ElementsAre(1, 3, 4, 5));
  EXPECT_THAT(graph->outputs, ElementsAre("out"));
  EXPECT_THAT(graph->constants.at("w")->shape, ElementsAre(2, 3, 3, 3));
  EXPECT_EQ(graph->constants.at("w")->floats, random_values(54, 1));
  EXPECT_THAT(graph->constants.at("shape")->integers, ElementsAre(1, -1));
}

TEST(OnnxGraph, RefusesATensorThatIsNotAsLargeAsItsShape) {
  TinyGraph graph = small_graph();
  graph.constants[1] = tensor("b", {3}, std::vector<float>{1, 2});
  const std::string file = onnx(graph);
  EXPECT_ERROR(read_onnx_graph(bytes_of(file)), "\"b\" of 2 values, not of the 3 of its shape 3");
  graph.constants[1] = tensor("b", {1 << 20, 1 << 20, 1 << 20}, std::vector<float>{1});
  const std::string huge = onnx(graph);
  EXPECT_ERROR(read_onnx_graph(bytes_of(huge)), "impossible shape");
}

TEST(OnnxGraph, RefusesATensorInAnotherFile) {
  TinyGraph graph = small_graph();
  graph.constants[1] += field(14, 1);
  const std::string file = onnx(graph);
  EXPECT_ERROR(read_onnx_graph(bytes_of(file)), "keeps the tensor \"b\" in another file");
}

TEST(OnnxGraph, RefusesWeightsThatAreNotFinite) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const auto check = [](const TinyGraph& tiny) {
    const std::string file = onnx(tiny);
    return check_weights(read_onnx_graph(bytes_of(file)).value());
  };
  TinyGraph graph = small_graph();
  EXPECT_OK(check(graph));
  graph.constants[1] = tensor("b", {2}, std::vector<float>{1, std::nanf("")});
  EXPECT_ERROR(check(graph), "its tensor \"b\" holds 1 of 2 numbers that are not finite");
  graph.constants[1] = tensor("b", {2}, std::vector<float>{kInfinity, 1});
  EXPECT_ERROR(check(graph), "\"b\"");
  graph.constants[1] = tensor("b", {2}, std::vector<float>{-kInfinity, 0});
  EXPECT_ERROR(check(graph), "\"b\"");
  // A mask, which a sum takes.
  graph.nodes[0] = layer("Add", {"picture", "b"}, {"c"});
  EXPECT_OK(check(graph));
  // In a node rather than beside the nodes.
  graph.constants.erase(graph.constants.begin() + 1);
  graph.nodes.push_back(
      layer("Constant", {}, {"b"},
            {field(5, field(1, std::string("value")) +
                          field(5, tensor("", {1}, std::vector<float>{std::nanf("")})))}));
  EXPECT_ERROR(check(graph), "its tensor \"b\" holds 1 of 1");
}

TEST(OnnxGraph, RefusesWhatIsNoNetwork) {
  EXPECT_ERROR(read_onnx_graph({}), "no ONNX network");
  EXPECT_ERROR(read_onnx_graph(bytes_of("garbage, and more of it")), "no ONNX network");
}

TEST(OnnxGraph, EveryTruncationIsAnErrorOrAnotherNetwork) {
  const std::string whole = onnx(small_graph());
  for (std::size_t kept = 0; kept < whole.size(); ++kept) {
    EXPECT_FALSE(load(whole.substr(0, kept)).has_value()) << kept;
  }
}

// Of more kinds of layers, so that damage finds more to work on.
TinyGraph varied_graph() {
  return {{layer("MaxPool", {"picture"}, {"p"}, {attribute("kernel_shape", {2, 2})}),
           layer("Slice", {"p", "one", "many", "one"}, {"s"}),
           layer("Concat", {"p", "s"}, {"j"}, {attribute("axis", 1)}),
           layer("Resize", {"j", "", "scales"}, {"l"}, {attribute("mode", "linear")}),
           layer("ReduceMean", {"l"}, {"m"}, {attribute("axes", {1, 3})}),
           layer("Transpose", {"l"}, {"t"}, {attribute("perm", {0, 2, 1, 3})}),
           layer("Sub", {"m", "l"}, {"d"}), layer("Softmax", {"t"}, {"x"}),
           layer("Gather", {"x", "one"}, {"g"}, {attribute("axis", 1)}),
           layer("Pad", {"g", "pads"}, {"out"})},
          {tensor("one", {1}, std::vector<std::int64_t>{1}),
           tensor("many", {1}, std::vector<std::int64_t>{9}),
           tensor("pads", {8}, std::vector<std::int64_t>{0, 0, 0, 1, 0, 0, 0, 1}),
           tensor("scales", {4}, std::vector<float>{1, 1, 2, 2})},
          {1, 3, 4, 5},
          {{"d", {}}, {"out", {}}}};
}

// One input of each, whatever sizes are free.
std::vector<Tensor> some_inputs(const OnnxGraph& graph) {
  std::vector<Tensor> inputs;
  for (const GraphInput& input : graph.inputs) {
    Shape shape = input.shape;
    for (std::int64_t& side : shape) side = side < 0 ? 5 : side;
    inputs.push_back(random_tensor(shape));
  }
  return inputs;
}

// Whatever the bytes say, there is a network that runs or an error, but no crash and no endless
// memory.
void expect_survives_damage(const std::string& whole) {
  RandomStream random(7);
  int refused = 0, ran = 0;
  for (int round = 0; round < 3000; ++round) {
    std::string damaged = whole;
    for (std::uint64_t i = 0; i <= random.index(4); ++i) {
      damaged[random.index(damaged.size())] = static_cast<char>(random.index(256));
    }
    const auto graph = read_onnx_graph(bytes_of(damaged));
    if (!graph) {
      ++refused;
      continue;
    }
    // A picture may have become so large that running it would take long: small ones are run.
    std::size_t size = 1;
    for (const std::int64_t side : graph->inputs[0].shape)
      size *= static_cast<std::size_t>(std::clamp<std::int64_t>(side, 1, 1 << 20));
    if (size > 1 << 16) continue;
    const auto executor = Executor::create(*graph);
    const bool runs = executor && (*executor)->run(some_inputs(*graph)).has_value();
    ++(runs ? ran : refused);
  }
  EXPECT_GT(refused, 100);
  EXPECT_GT(ran, 100);
}

TEST(OnnxGraph, SurvivesDamage) {
  expect_survives_damage(onnx(small_graph()));
  expect_survives_damage(onnx(varied_graph()));
}

// A few bytes that ask for terabytes.
TEST(OnnxGraph, RefusesToGrowWithoutEnd) {
  TinyGraph graph{
      {}, {tensor("size", {1}, std::vector<std::int64_t>{1 << 22})}, {1, 3}, {{"picture", {1, 3}}}};
  for (int i = 0; i < 1000; ++i) {
    graph.nodes.push_back(layer("ConstantOfShape", {"size"}, {"c" + std::to_string(i)}));
  }
  EXPECT_ERROR(load(onnx(graph)), "more constants than any network needs");
  graph.nodes = {layer("Identity", {"one"}, {"c0"})};
  graph.constants.push_back(tensor("one", {2}, std::vector<float>{1, 2}));
  for (int i = 0; i < 60; ++i) {
    const std::string from = "c" + std::to_string(i), to = "c" + std::to_string(i + 1);
    graph.nodes.push_back(layer("Concat", {from, from}, {to}, {attribute("axis", 0)}));
  }
  EXPECT_ERROR(load(onnx(graph)), "more constants than any network needs");
  // A single node that does is named, since it is refused before it is worked out.
  for (const char* from : {"number", "picture"}) {
    graph.nodes = {layer("Expand", {from, "size"}, {"c0"})};
    graph.constants = {tensor("size", {3}, std::vector<std::int64_t>{1 << 26, 1, 1}),
                       tensor("number", {}, std::vector<std::int64_t>{1})};
    graph.input = {1, 1, 1};
    EXPECT_ERROR(load(onnx(graph)), "(Expand, opset 11): asks for more constants than any");
  }
  graph.nodes = {layer("ConstantOfShape", {"size"}, {"c0"})};
  EXPECT_ERROR(load(onnx(graph)), "(ConstantOfShape, opset 11): asks for more constants than any");
}

}  // namespace
}  // namespace roomwise::network
