// Each operator against OpenCV, or against values worked out by hand where OpenCV lacks it.
#include <gmock/gmock.h>

#include "roomwise/network/formats/onnx_writer.h"
#include "roomwise/network/graph/lowering.h"
#include "roomwise/network/testing/tiny_runs.h"

namespace roomwise::network {
namespace {

using namespace testing;
using ::testing::ElementsAre;
using ::testing::ElementsAreArray;
using ::testing::FloatNear;
using ::testing::HasSubstr;
using ::testing::Pointwise;
using Integers = std::vector<std::int64_t>;

// One node between "picture" and "out". (The sizes that a file gives its outputs are not read.)
TinyGraph one_node(const std::string& operation, std::vector<std::uint64_t> input,
                   const std::vector<std::string>& attributes = {},
                   const std::vector<std::string>& further = {},
                   const std::vector<std::string>& constants = {}) {
  std::vector<std::string> inputs{"picture"};
  inputs.insert(inputs.end(), further.begin(), further.end());
  return {
      {layer(operation, inputs, {"out"}, attributes)}, constants, std::move(input), {{"out", {}}}};
}

std::vector<float> values_of(const TinyGraph& graph, const std::vector<float>& input) {
  const auto outputs = run(onnx(graph), {input_shape(graph), input});
  EXPECT_TRUE(outputs.has_value()) << outputs.error().message;
  return outputs ? outputs->front().values : std::vector<float>{};
}

Shape shape_of(const TinyGraph& graph) {
  const auto outputs = run(onnx(graph), random_tensor(input_shape(graph)));
  EXPECT_TRUE(outputs.has_value()) << outputs.error().message;
  return outputs ? outputs->front().shape : Shape{};
}

TEST(Operators, Convolutions) {
  const auto convolution = [](Integers weights, std::vector<std::uint64_t> input,
                              std::vector<std::string> attributes) {
    attributes.push_back(attribute("kernel_shape", Integers{weights[2], weights[3]}));
    return one_node("Conv", std::move(input), attributes, {"w", "b"},
                    {random_weights("w", weights, 2), random_weights("b", {weights[0]}, 3)});
  };
  expect_like_opencv(convolution({5, 3, 3, 3}, {1, 3, 9, 8}, {}));
  expect_like_opencv(convolution({24, 7, 1, 1}, {1, 7, 9, 8}, {}));
  expect_like_opencv(
      convolution({20, 18, 3, 5}, {2, 18, 11, 9},
                  {attribute("pads", Integers{1, 2, 1, 2}), attribute("strides", Integers{2, 1})}));
  expect_like_opencv(convolution(
      {16, 16, 3, 3}, {1, 16, 13, 13},
      {attribute("dilations", Integers{2, 2}), attribute("pads", Integers{2, 2, 2, 2})}));
  for (const char* automatic : {"SAME_UPPER", "VALID"}) {
    expect_like_opencv(
        convolution({6, 4, 3, 3}, {1, 4, 8, 8},
                    {attribute("auto_pad", automatic), attribute("strides", Integers{2, 2})}));
  }
}

TEST(Operators, ConvolutionsInGroups) {
  const auto convolution = [](Integers weights, std::uint64_t channels, int groups) {
    return one_node("Conv", {1, channels, 10, 7},
                    {attribute("group", groups), attribute("pads", Integers{1, 1, 1, 1}),
                     attribute("kernel_shape", Integers{3, 3})},
                    {"w"}, {random_weights("w", weights, 2)});
  };
  expect_like_opencv(convolution({58, 1, 3, 3}, 58, 58));
  expect_like_opencv(convolution({12, 3, 3, 3}, 6, 2));
  expect_like_opencv(convolution({64, 16, 3, 3}, 32, 2));
  expect_like_opencv(convolution({10, 1, 3, 3}, 5, 5));
}

TEST(Operators, SameLowerPutsTheOddPadFirst) {
  const TinyGraph graph =
      one_node("Conv", {1, 1, 1, 4},
               {attribute("auto_pad", "SAME_LOWER"), attribute("kernel_shape", Integers{1, 2})},
               {"w"}, {tensor("w", {1, 1, 1, 2}, std::vector<float>{1, 10})});
  EXPECT_THAT(values_of(graph, {1, 2, 3, 4}), ElementsAre(10, 21, 32, 43));
  EXPECT_ERROR(load(onnx(one_node(
                   "MaxPool", {1, 1, 4, 4},
                   {attribute("auto_pad", "SAME"), attribute("kernel_shape", Integers{2, 2})}))),
               "its auto_pad \"SAME\" is none of NOTSET, ");
}

TEST(Operators, Pooling) {
  const std::vector<std::string> window{attribute("kernel_shape", Integers{3, 3}),
                                        attribute("strides", Integers{2, 2}),
                                        attribute("pads", Integers{1, 1, 1, 1})};
  expect_like_opencv(one_node("MaxPool", {1, 18, 9, 11}, window));
  expect_like_opencv(one_node("AveragePool", {1, 18, 9, 11}, window));
  expect_like_opencv(one_node("GlobalAveragePool", {2, 18, 9, 11}));
  auto counting = window;
  counting.push_back(attribute("count_include_pad", 1));
  const TinyGraph corner = one_node("AveragePool", {1, 1, 1, 1}, counting);
  EXPECT_THAT(values_of(corner, {9}), ElementsAre(1));
  EXPECT_ERROR(load(onnx(one_node("MaxPool", {1, 1, 4, 4}))), "lacks its kernel_shape");
}

// Without dilation a window of 2 gives as many outputs, but others.
TEST(Operators, PoolingWithDilationIsRefused) {
  for (const char* operation : {"MaxPool", "AveragePool"}) {
    EXPECT_ERROR(load(onnx(one_node(operation, {1, 1, 9, 9},
                                    {attribute("kernel_shape", Integers{2, 2}),
                                     attribute("dilations", Integers{2, 2}),
                                     attribute("strides", Integers{2, 2})}))),
                 "its dilations of 2 and 2 are not supported");
  }
}

TEST(Operators, PoolingThatRoundsUp) {
  const TinyGraph graph =
      one_node("MaxPool", {1, 1, 1, 6},
               {attribute("kernel_shape", Integers{1, 3}), attribute("strides", Integers{1, 2}),
                attribute("ceil_mode", 1)});
  EXPECT_THAT(values_of(graph, {1, 2, 3, 4, 5, 6}), ElementsAre(3, 5, 6));
}

TEST(Operators, Means) {
  const TinyGraph spatial = one_node("ReduceMean", {1, 2, 2, 2},
                                     {attribute("axes", Integers{2, 3}), attribute("keepdims", 0)});
  EXPECT_THAT(values_of(spatial, {1, 2, 3, 4, 5, 6, 7, 8}), ElementsAre(2.5, 6.5));
  EXPECT_THAT(shape_of(spatial), ElementsAre(1, 2));
  const TinyGraph channels = one_node("ReduceMean", {1, 2, 2}, {attribute("axes", Integers{1})});
  EXPECT_THAT(values_of(channels, {1, 2, 3, 4}), ElementsAre(2, 3));
  EXPECT_THAT(shape_of(channels), ElementsAre(1, 1, 2));
  for (const Integers& axes : {Integers{1, 1}, Integers{1, -3}}) {
    EXPECT_ERROR(load(onnx(one_node("ReduceMean", {1, 2, 2, 2}, {attribute("axes", axes)}))),
                 "names the axis 1 twice");
  }
}

TEST(Operators, ElementwiseFunctions) {
  const std::vector<std::uint64_t> input{1, 18, 5, 4};
  for (const char* operation : {"Relu", "LeakyRelu", "Sigmoid", "Tanh", "Exp"}) {
    SCOPED_TRACE(operation);
    expect_like_opencv(one_node(operation, input));
  }
  expect_like_opencv(one_node("LeakyRelu", input, {attribute("alpha", 0.3F)}));
  TinyGraph old_clip = one_node("Clip", input, {attribute("min", -0.5F), attribute("max", 0.75F)});
  old_clip.opset = 10;
  expect_like_opencv(old_clip);
  const TinyGraph clip = one_node(
      "Clip", {1, 3}, {}, {"low", "high"},
      {tensor("low", {}, std::vector<float>{-1}), tensor("high", {}, std::vector<float>{6})});
  EXPECT_THAT(values_of(clip, {-2, 3, 8}), ElementsAre(-1, 3, 6));
  const TinyGraph half_open =
      one_node("Clip", {1, 3}, {}, {"", "high"}, {tensor("high", {}, std::vector<float>{6})});
  EXPECT_THAT(values_of(half_open, {-2, 3, 8}), ElementsAre(-2, 3, 6));
}

TEST(Operators, HardFunctions) {
  const TinyGraph sigmoid =
      one_node("HardSigmoid", {1, 4}, {attribute("alpha", 0.25F), attribute("beta", 0.5F)});
  EXPECT_THAT(values_of(sigmoid, {-4, -1, 1, 4}), ElementsAre(0, 0.25, 0.75, 1));
  TinyGraph swish = one_node("HardSwish", {1, 4});
  swish.opset = 14;
  EXPECT_THAT(values_of(swish, {-4, 0, 3, 6}), Pointwise(FloatNear(1e-6F), {0.F, 0.F, 3.F, 6.F}));
}

TEST(Operators, BatchNormalization) {
  expect_like_opencv(
      one_node("BatchNormalization", {1, 18, 5, 4}, {}, {"g", "b", "m", "v"},
               {random_weights("g", {18}, 2), random_weights("b", {18}, 3),
                random_weights("m", {18}, 4), tensor("v", {18}, std::vector<float>(18, 1.5F))}));
}

TEST(Operators, ArithmeticBroadcasts) {
  const std::vector<float> picture{1, 2, 3, 4, 5, 6, 7, 8};
  const auto with = [](const char* operation, Integers shape, std::vector<float> values) {
    return one_node(operation, {1, 2, 2, 2}, {}, {"c"}, {tensor("c", shape, values)});
  };
  EXPECT_THAT(values_of(with("Add", {}, {10}), picture),
              ElementsAre(11, 12, 13, 14, 15, 16, 17, 18));
  EXPECT_THAT(values_of(with("Mul", {2, 1, 1}, {2, 10}), picture),
              ElementsAre(2, 4, 6, 8, 50, 60, 70, 80));
  EXPECT_THAT(values_of(with("Sub", {1, 1, 1, 2}, {1, 2}), picture),
              ElementsAre(0, 0, 2, 2, 4, 4, 6, 6));
  EXPECT_THAT(values_of(with("Div", {1, 1, 2, 1}, {1, 2}), picture),
              ElementsAre(1, 2, 1.5, 2, 5, 6, 3.5, 4));
  // Both grow, along different axes.
  TinyGraph both{{layer("Sub", {"c", "picture"}, {"out"})},
                 {tensor("c", {2, 1, 2}, std::vector<float>{10, 20, 30, 40})},
                 {2, 1},
                 {{"out", {}}}};
  EXPECT_THAT(values_of(both, {1, 2}), ElementsAre(9, 19, 8, 18, 29, 39, 28, 38));
  TinyGraph single{{layer("Div", {"c", "picture"}, {"out"})},
                   {tensor("c", {}, std::vector<float>{12})},
                   {1, 3},
                   {{"out", {}}}};
  EXPECT_THAT(values_of(single, {1, 2, 3}), ElementsAre(12, 6, 4));
  // The constant is the larger one, and stands first.
  TinyGraph grows{{layer("Sub", {"c", "picture"}, {"out"})},
                  {tensor("c", {2, 2}, std::vector<float>{10, 20, 30, 40})},
                  {1, 2},
                  {{"out", {}}}};
  EXPECT_THAT(values_of(grows, {1, 2}), ElementsAre(9, 18, 29, 38));
}

// A gate of one number a channel, as in squeeze-and-excitation.
TEST(Operators, GatesOfChannels) {
  TinyGraph graph{
      {layer("GlobalAveragePool", {"picture"}, {"pooled"}),
       layer("Conv", {"pooled", "w"}, {"squeezed"}, {attribute("kernel_shape", Integers{1, 1})}),
       layer("Sigmoid", {"squeezed"}, {"gate"}), layer("Mul", {"picture", "gate"}, {"out"})},
      {random_weights("w", {20, 20, 1, 1}, 5)},
      {1, 20, 6, 5},
      {{"out", {}}}};
  expect_like_opencv(graph);
}

TEST(Operators, Products) {
  expect_like_opencv(one_node("Gemm", {1, 12}, {attribute("transB", 1)}, {"w", "b"},
                              {random_weights("w", {5, 12}, 2), random_weights("b", {5}, 3)}));
  const TinyGraph scaled = one_node(
      "Gemm", {2, 1}, {attribute("alpha", 2.0F), attribute("beta", 3.0F)}, {"w", "b"},
      {tensor("w", {1, 2}, std::vector<float>{1, 10}), tensor("b", {2}, std::vector<float>{1, 2})});
  EXPECT_THAT(values_of(scaled, {1, 2}), ElementsAre(5, 26, 7, 46));
  const TinyGraph batches =
      one_node("MatMul", {2, 1, 2}, {}, {"w"}, {tensor("w", {2, 1}, std::vector<float>{1, 10})});
  EXPECT_THAT(values_of(batches, {1, 2, 3, 4}), ElementsAre(21, 43));
  const TinyGraph whole =
      one_node("Gemm", {1, 2}, {}, {"w", "b"},
               {tensor("w", {2, 2}, std::vector<float>(4, 1)), tensor("b", {2}, Integers{5, 6})});
  EXPECT_ERROR(load(onnx(whole)), "works on whole numbers");
}

TEST(Operators, SoftmaxOfOldAndNew) {
  TinyGraph old = one_node("Softmax", {1, 2, 3}, {attribute("axis", 1)});
  TinyGraph current = one_node("Softmax", {1, 2, 3}, {attribute("axis", 1)});
  current.opset = 13;
  const std::vector<float> input{0, 0, 0, 0, 0, 0};
  // Before opset 13 everything from the axis on is one axis.
  EXPECT_THAT(values_of(old, input), Pointwise(FloatNear(1e-6F), std::vector<float>(6, 1.F / 6)));
  EXPECT_THAT(values_of(current, input), Pointwise(FloatNear(1e-6F), std::vector<float>(6, 0.5F)));
}

TEST(Operators, JoinsAndSplits) {
  for (const std::int64_t channels : {16, 58}) {
    TinyGraph graph{{layer("Relu", {"picture"}, {"a"}), layer("Sigmoid", {"picture"}, {"b"}),
                     layer("Concat", {"a", "b", "a"}, {"joined"}, {attribute("axis", 1)}),
                     layer("Split", {"joined"}, {"first", "second"},
                           {attribute("axis", 1),
                            attribute("split", Integers{channels + 3, 2 * channels - 3})}),
                     layer("Tanh", {"first"}, {"warm"}),
                     layer("Concat", {"second", "warm"}, {"out"}, {attribute("axis", 1)})},
                    {},
                    {1, static_cast<std::uint64_t>(channels), 5, 6},
                    {{"out", {}}}};
    expect_like_opencv(graph);
  }
  const TinyGraph columns{
      {layer("Concat", {"picture", "picture"}, {"out"}, {attribute("axis", -1)})},
      {},
      {2, 2},
      {{"out", {}}}};
  EXPECT_THAT(values_of(columns, {1, 2, 3, 4}), ElementsAre(1, 2, 1, 2, 3, 4, 3, 4));
}

TEST(Operators, Slices) {
  const auto slice = [](Integers starts, Integers ends, Integers axes, Integers steps) {
    const auto list = [](const char* name, const Integers& values) {
      return tensor(name, {static_cast<std::int64_t>(values.size())}, values);
    };
    return one_node("Slice", {1, 1, 4, 4}, {}, {"s", "e", "a", "t"},
                    {list("s", starts), list("e", ends), list("a", axes), list("t", steps)});
  };
  std::vector<float> picture(16);
  for (std::size_t i = 0; i < 16; ++i) picture[i] = static_cast<float>(i);
  EXPECT_THAT(values_of(slice({1, 0}, {1000, -1}, {2, 3}, {2, 2}), picture),
              ElementsAre(4, 6, 12, 14));
  EXPECT_THAT(values_of(slice({-1}, {-1000}, {3}, {-3}), picture),
              ElementsAre(3, 0, 7, 4, 11, 8, 15, 12));
  EXPECT_ERROR(load(onnx(slice({0}, {1}, {3}, {0}))), "its step is 0");
  EXPECT_ERROR(load(onnx(slice({0, 0}, {1, 1}, {2}, {1, 1}))), "are not of one number");
  EXPECT_ERROR(load(onnx(slice({0, 0}, {1, 1}, {2, 3}, {1}))), "are not of one number");
  EXPECT_ERROR(load(onnx(slice({0, 0}, {1, 1}, {2, -2}, {1, 1}))), "names the axis 2 twice");
  const auto of_first_axes = [](std::uint64_t axes) {
    const Integers begins(axes, 1), ends(axes, 2);
    return one_node("Slice", {2, 2}, {}, {"s", "e"},
                    {tensor("s", {static_cast<std::int64_t>(axes)}, begins),
                     tensor("e", {static_cast<std::int64_t>(axes)}, ends)});
  };
  EXPECT_THAT(values_of(of_first_axes(2), {1, 2, 3, 4}), ElementsAre(4));
  EXPECT_ERROR(load(onnx(of_first_axes(3))), "slices 3 axes of 2");
}

TEST(Operators, Pads) {
  const TinyGraph graph = one_node("Pad", {1, 1, 2, 2}, {}, {"pads", "value"},
                                   {tensor("pads", {8}, Integers{0, 0, 1, 0, 0, 0, 0, 1}),
                                    tensor("value", {}, std::vector<float>{7})});
  EXPECT_THAT(values_of(graph, {1, 2, 3, 4}), ElementsAre(7, 7, 7, 1, 2, 7, 3, 4, 7));
  EXPECT_ERROR(load(onnx(one_node("Pad", {1, 1, 2, 2}, {attribute("mode", "reflect")}))),
               "\"reflect\" is not supported");
}

TEST(Operators, Reshapes) {
  const auto reshape = [](Integers shape) {
    return one_node("Reshape", {1, 2, 3, 4}, {}, {"s"},
                    {tensor("s", {static_cast<std::int64_t>(shape.size())}, shape)});
  };
  EXPECT_THAT(shape_of(reshape({0, -1, 4})), ElementsAre(1, 6, 4));
  EXPECT_ERROR(load(onnx(reshape({5, 5}))), "cannot bring 1x2x3x4 into the shape 5x5");
  EXPECT_THAT(shape_of(one_node("Flatten", {2, 3, 4}, {attribute("axis", 2)})), ElementsAre(6, 4));
  EXPECT_THAT(shape_of(one_node("Squeeze", {1, 3, 1}, {attribute("axes", Integers{-1})})),
              ElementsAre(1, 3));
  EXPECT_ERROR(load(onnx(one_node("Squeeze", {1, 3, 1}, {attribute("axes", Integers{2, -1})}))),
               "names the axis 2 twice");
  EXPECT_ERROR(load(onnx(one_node("Unsqueeze", {3}, {attribute("axes", Integers{0, -3})}))),
               "names the axis 0 twice");
  EXPECT_ERROR(load(onnx(one_node("Transpose", {2, 3}, {attribute("perm", Integers{0, 0})}))),
               "names the axis 0 twice");
  EXPECT_THAT(shape_of(one_node("Unsqueeze", {3}, {attribute("axes", Integers{0, 2})})),
              ElementsAre(1, 3, 1));
  const TinyGraph transpose =
      one_node("Transpose", {1, 2, 3}, {attribute("perm", Integers{2, 0, 1})});
  EXPECT_THAT(shape_of(transpose), ElementsAre(3, 1, 2));
  EXPECT_THAT(values_of(transpose, {1, 2, 3, 4, 5, 6}), ElementsAre(1, 4, 2, 5, 3, 6));
}

TEST(Operators, ShapesAreWorkedOutBeforehand) {
  // Reshape(x, [Shape(x)[0], -1]), as PyTorch exports a flattening.
  TinyGraph graph{
      {layer("Shape", {"picture"}, {"shape"}), layer("Gather", {"shape", "zero"}, {"batch"}),
       layer("Unsqueeze", {"batch"}, {"batch1"}, {attribute("axes", Integers{0})}),
       layer("Cast", {"batch1"}, {"float"}, {attribute("to", 1)}),
       layer("Mul", {"float", "two"}, {"twice"}),
       layer("Cast", {"twice"}, {"whole"}, {attribute("to", 7)}),
       layer("Concat", {"whole", "rest"}, {"wanted"}, {attribute("axis", 0)}),
       layer("Reshape", {"picture", "wanted"}, {"out"})},
      {tensor("zero", {}, Integers{0}), tensor("rest", {1}, Integers{-1}),
       tensor("two", {}, std::vector<float>{2})},
      {1, 2, 3, 4},
      {{"out", {}}}};
  EXPECT_THAT(shape_of(graph), ElementsAre(2, 12));
}

TEST(Operators, GatherPicksFromPictures) {
  const TinyGraph graph = one_node("Gather", {1, 3, 2}, {attribute("axis", 1)}, {"i"},
                                   {tensor("i", {2}, Integers{-1, 0})});
  EXPECT_THAT(values_of(graph, {1, 2, 3, 4, 5, 6}), ElementsAre(5, 6, 1, 2));
  EXPECT_ERROR(load(onnx(one_node("Gather", {1, 3, 2}, {}, {"i"},
                                  {tensor("i", {1}, std::vector<float>{0})}))),
               "its indices are no whole numbers");
}

TEST(Operators, Resizes) {
  for (const std::uint64_t channels : {3U, 20U}) {
    const auto resize = [&](const char* mode, const char* coordinates, const char* nearest) {
      return one_node(
          "Resize", {1, channels, 4, 5},
          {attribute("mode", mode), attribute("coordinate_transformation_mode", coordinates),
           attribute("nearest_mode", nearest)},
          {"", "scales"}, {tensor("scales", {4}, std::vector<float>{1, 1, 2, 2})});
    };
    expect_like_opencv(resize("nearest", "asymmetric", "floor"));
    // A convolution before it, so that it works in blocks of channels.
    TinyGraph in_blocks = resize("linear", "half_pixel", "floor");
    in_blocks.nodes = {
        layer("Conv", {"picture", "w"}, {"c"}, {attribute("kernel_shape", Integers{1, 1})}),
        layer("Resize", {"c", "", "scales"}, {"out"},
              {attribute("mode", "linear"),
               attribute("coordinate_transformation_mode", "half_pixel")})};
    in_blocks.constants.push_back(
        random_weights("w", {24, static_cast<std::int64_t>(channels), 1, 1}, 3));
    expect_like_opencv(in_blocks);
  }
  const TinyGraph corners = one_node(
      "Resize", {1, 1, 1, 2},
      {attribute("mode", "linear"), attribute("coordinate_transformation_mode", "align_corners")},
      {"", "", "sizes"}, {tensor("sizes", {4}, Integers{1, 1, 1, 5})});
  EXPECT_THAT(values_of(corners, {0, 4}), ElementsAre(0, 1, 2, 3, 4));
  EXPECT_ERROR(
      load(onnx(one_node("Resize", {1, 1, 1, 2}, {attribute("nearest_mode", "round")},
                         {"", "", "sizes"}, {tensor("sizes", {4}, Integers{1, 1, 1, 5})}))),
      "its nearest_mode \"round\" is none of round_prefer_floor, ");
}

// One node between two inputs ("picture" and whole numbers) and "out", of opset 17.
std::vector<std::uint8_t> with_tokens(Node node, Shape picture, Shape tokens) {
  OnnxGraph graph;
  graph.opset = 17;
  node.name = "the node";
  graph.nodes.push_back(std::move(node));
  graph.inputs = {{"picture", std::move(picture)}, {"tokens", std::move(tokens), true}};
  graph.outputs = {graph.nodes.back().outputs.front()};
  return write_onnx_graph(graph).value();
}

Expected<std::vector<Tensor>> run_two(const std::vector<std::uint8_t>& file, const Tensor& first,
                                      const Tensor& second) {
  ROOMWISE_TRY(OnnxGraph graph, read_onnx_graph(file));
  ROOMWISE_TRY(const auto executor, Executor::create(std::move(graph)));
  return executor->run(std::vector{first, second});
}

TEST(Operators, WordsAreLookedUpByWholeNumbers) {
  const auto rows =
      with_tokens({"", "Gather", "", {"picture", "tokens"}, {"out"}, {}}, {3, 2}, {1, 2});
  const Tensor table{{3, 2}, {1, 2, 3, 4, 5, 6}};
  const auto found = run_two(rows, table, {{1, 2}, {2, -3}});
  ASSERT_OK(found);
  EXPECT_THAT(found->front().shape, ElementsAre(1, 2, 2));
  EXPECT_THAT(found->front().values, ElementsAre(5, 6, 1, 2));
  // In 32 bits -1e-9 + 97 is 97, which lies behind the table.
  const auto words = with_tokens({"", "Gather", "", {"picture", "tokens"}, {"out"}, {}}, {97}, {1});
  const Tensor many = random_tensor({97});
  EXPECT_EQ(run_two(words, many, {{1}, {-97}})->front().values.front(), many.values.front());
  for (const float none : {97.F, -98.F, -1e-9F, 1.7F, std::nanf(""), -INFINITY}) {
    EXPECT_ERROR(run_two(words, many, {{1}, {none}}), "node \"the node\": there is no index");
  }
  const auto columns = with_tokens(
      {"", "Gather", "", {"picture", "tokens"}, {"out"}, {{"axis", Attribute(std::int64_t{1})}}},
      {2, 3}, {2});
  const auto picked = run_two(columns, {{2, 3}, {1, 2, 3, 4, 5, 6}}, {{2}, {2, 0}});
  ASSERT_OK(picked);
  EXPECT_THAT(picked->front().values, ElementsAre(3, 1, 6, 4));
  EXPECT_ERROR(
      run_two(with_tokens({"", "Gather", "", {"tokens", "picture"}, {"out"}, {}}, {2}, {3}),
              {{2}, {0, 1}}, {{3}, {1, 2, 3}}),
      "node \"the node\" (Gather, opset 17): its indices are no whole numbers");
}

TEST(Operators, WholeNumbersAndOthersAreNotMixed) {
  EXPECT_ERROR(run_two(with_tokens({"", "Add", "", {"picture", "tokens"}, {"out"}, {}}, {2}, {2}),
                       {{2}, {1, 2}}, {{2}, {1, 2}}),
               "node \"the node\" (Add, opset 17): works on whole numbers");
  EXPECT_ERROR(run_two(with_tokens({"", "Sigmoid", "", {"tokens"}, {"out"}, {}}, {2}, {2}),
                       {{2}, {1, 2}}, {{2}, {1, 2}}),
               "works on whole numbers");
  EXPECT_ERROR(run_two(with_tokens({"", "Div", "", {"tokens", "tokens"}, {"out"}, {}}, {2}, {2}),
                       {{2}, {1, 2}}, {{2}, {1, 2}}),
               "divides whole numbers");
}

TEST(Operators, CastsOfWhatDependsOnTheInput) {
  const auto cast = [](const char* from, std::int64_t to) {
    return with_tokens({"", "Cast", "", {from}, {"out"}, {{"to", Attribute(to)}}}, {3}, {3});
  };
  const Tensor numbers{{3}, {0, -0.5, 2}}, tokens{{3}, {0, 7, -1}};
  EXPECT_THAT(run_two(cast("tokens", 1), numbers, tokens)->front().values, ElementsAre(0, 7, -1));
  EXPECT_THAT(run_two(cast("tokens", 6), numbers, tokens)->front().values, ElementsAre(0, 7, -1));
  EXPECT_THAT(run_two(cast("tokens", 9), numbers, tokens)->front().values, ElementsAre(0, 1, 1));
  EXPECT_THAT(run_two(cast("picture", 9), numbers, tokens)->front().values, ElementsAre(0, 1, 1));
  EXPECT_ERROR(run_two(cast("picture", 7), numbers, tokens), "to whole numbers is not supported");
}

TEST(Operators, TheLargestIndex) {
  const TinyGraph rows =
      one_node("ArgMax", {2, 3}, {attribute("axis", -1), attribute("keepdims", 0)});
  EXPECT_THAT(values_of(rows, {1, 5, 5, 9, 0, 2}), ElementsAre(1, 0));
  EXPECT_THAT(shape_of(rows), ElementsAre(2));
  const TinyGraph columns = one_node("ArgMax", {2, 3});
  EXPECT_THAT(values_of(columns, {1, 5, 5, 9, 0, 6}), ElementsAre(1, 0, 1));
  EXPECT_THAT(shape_of(columns), ElementsAre(1, 3));
  EXPECT_ERROR(load(onnx(one_node("ArgMax", {2, 3}, {attribute("select_last_index", 1)}))),
               "the last of several largest values is not supported");
}

TEST(Operators, SumsAndLengths) {
  const std::vector<float> input{3, 4, -6, 8};
  TinyGraph sum = one_node("ReduceSum", {2, 2}, {attribute("keepdims", 0)}, {"a"},
                           {tensor("a", {1}, Integers{-1})});
  sum.opset = 13;
  EXPECT_THAT(values_of(sum, input), ElementsAre(7, 2));
  EXPECT_THAT(shape_of(sum), ElementsAre(2));
  EXPECT_THAT(values_of(one_node("ReduceSum", {2, 2}, {attribute("axes", Integers{0})}), input),
              ElementsAre(-3, 12));
  EXPECT_THAT(values_of(one_node("ReduceL2", {2, 2}, {attribute("axes", Integers{-1})}), input),
              ElementsAre(5, 10));
}

TEST(Operators, LayerNormalization) {
  TinyGraph graph = one_node(
      "LayerNormalization", {2, 2}, {attribute("epsilon", 0.0F)}, {"g", "b"},
      {tensor("g", {2}, std::vector<float>{10, 1}), tensor("b", {2}, std::vector<float>{0, 5})});
  graph.opset = 17;
  EXPECT_THAT(values_of(graph, {1, 3, 10, 30}), ElementsAre(-10, 6, -10, 6));
  graph.constants = {tensor("g", {3}, std::vector<float>(3, 1)),
                     tensor("b", {2}, std::vector<float>(2))};
  EXPECT_ERROR(load(onnx(graph)), "do not fit each other");
}

TEST(Operators, RootsPowersAndTheErrorFunction) {
  EXPECT_THAT(values_of(one_node("Sqrt", {1, 3}), {0, 4, 9}), ElementsAre(0, 2, 3));
  EXPECT_THAT(values_of(one_node("Erf", {1, 3}), {0, 1, -0.5F}),
              Pointwise(FloatNear(1e-6F), {0.F, 0.842700793F, -0.520499878F}));
  EXPECT_THAT(values_of(one_node("Neg", {1, 2}), {3, -4}), ElementsAre(-3, 4));
  const auto power = [](float exponent) {
    return one_node("Pow", {1, 3}, {}, {"p"}, {tensor("p", {}, std::vector<float>{exponent})});
  };
  EXPECT_THAT(values_of(power(2), {3, -4, 0.5F}), ElementsAre(9, 16, 0.25));
  EXPECT_THAT(values_of(power(3), {3, -4, 0.5F}),
              Pointwise(FloatNear(1e-5F), {27.F, -64.F, 0.125F}));
  EXPECT_THAT(values_of(power(-0.5F), {4, 16, 1}), Pointwise(FloatNear(1e-6F), {0.5F, 0.25F, 1.F}));
  // Behind a convolution, which takes other functions into itself.
  const TinyGraph behind{
      {layer("Conv", {"picture", "w"}, {"c"}, {attribute("kernel_shape", Integers{1, 1})}),
       layer("Erf", {"c"}, {"out"})},
      {tensor("w", {1, 1, 1, 1}, std::vector<float>{2})},
      {1, 1, 1, 1},
      {{"out", {}}}};
  EXPECT_THAT(values_of(behind, {0.5F}), Pointwise(FloatNear(1e-6F), {0.842700793F}));
}

TEST(Operators, Comparisons) {
  const auto with = [](const char* operation) {
    return one_node(operation, {1, 3}, {}, {"c"}, {tensor("c", {1}, std::vector<float>{2})});
  };
  const std::vector<float> input{1, 2, 3};
  EXPECT_THAT(values_of(with("Equal"), input), ElementsAre(0, 1, 0));
  EXPECT_THAT(values_of(with("Less"), input), ElementsAre(1, 0, 0));
  EXPECT_THAT(values_of(with("Greater"), input), ElementsAre(0, 0, 1));
  EXPECT_THAT(values_of(with("Max"), input), ElementsAre(2, 2, 3));
  EXPECT_THAT(values_of(with("Min"), input), ElementsAre(1, 2, 2));
  const auto both = [](const char* operation) {
    return TinyGraph{
        {layer("Less", {"picture", "c"}, {"l"}), layer("Greater", {"picture", "d"}, {"g"}),
         layer(operation, {"l", "g"}, {"j"}), layer("Not", {"j"}, {"out"})},
        {tensor("c", {}, std::vector<float>{3}), tensor("d", {}, std::vector<float>{1})},
        {1, 3},
        {{"out", {}}}};
  };
  EXPECT_THAT(values_of(both("And"), input), ElementsAre(1, 0, 1));
  EXPECT_THAT(values_of(both("Or"), {1, 2, 3}), ElementsAre(0, 0, 0));
}

// By infinity too, which no sum of products could choose.
TEST(Operators, Selections) {
  constexpr float kInfinite = std::numeric_limits<float>::infinity();
  const TinyGraph graph{{layer("Greater", {"picture", "c"}, {"chosen"}),
                         layer("Where", {"chosen", "far", "picture"}, {"out"})},
                        {tensor("c", {2, 1}, std::vector<float>{1, 2}),
                         tensor("far", {}, std::vector<float>{-kInfinite})},
                        {1, 3},
                        {{"out", {}}}};
  EXPECT_THAT(values_of(graph, {1, 2, 3}),
              ElementsAre(1, -kInfinite, -kInfinite, 1, 2, -kInfinite));
  EXPECT_ERROR(load(onnx(one_node("Where", {1, 3}, {}, {"picture", "picture"}))),
               "its condition is no truth value");
}

// A mask of what comes later, worked out beforehand: -infinity above the diagonal.
TEST(Operators, MasksKnownBeforehand) {
  constexpr float kInfinite = std::numeric_limits<float>::infinity();
  const std::vector<std::string> numbers{tensor("zero", {}, Integers{0}),
                                         tensor("three", {}, Integers{3}),
                                         tensor("one", {}, Integers{1}),
                                         tensor("column", {2}, Integers{3, 1}),
                                         tensor("far", {}, std::vector<float>{-kInfinite}),
                                         tensor("none", {}, std::vector<float>{0})};
  TinyGraph ranges{{layer("Range", {"zero", "three", "one"}, {"places"}),
                    layer("Reshape", {"places", "column"}, {"below"}),
                    layer("Greater", {"places", "below"}, {"later"}),
                    layer("Where", {"later", "far", "none"}, {"mask"}),
                    layer("Add", {"picture", "mask"}, {"sum"}), layer("Softmax", {"sum"}, {"out"})},
                   numbers,
                   {3, 3},
                   {{"out", {}}}};
  ranges.opset = 14;
  const auto expected = {1.F, 0.F, 0.F, 0.5F, 0.5F, 0.F, 1.F / 3, 1.F / 3, 1.F / 3};
  EXPECT_THAT(values_of(ranges, std::vector<float>(9, 1)), Pointwise(FloatNear(1e-6F), expected));
  TinyGraph triangle = ranges;
  triangle.nodes = {layer("Trilu", {"full", "one"}, {"mask"}, {attribute("upper", 1)}),
                    layer("Add", {"picture", "mask"}, {"sum"}), layer("Softmax", {"sum"}, {"out"})};
  triangle.constants.push_back(tensor("full", {3, 3}, std::vector<float>(9, -kInfinite)));
  EXPECT_THAT(values_of(triangle, std::vector<float>(9, 1)), Pointwise(FloatNear(1e-6F), expected));
  TinyGraph lower = triangle;
  lower.nodes = {layer("Trilu", {"full"}, {"mask"}, {attribute("upper", 0)}),
                 layer("Add", {"picture", "mask"}, {"out"})};
  lower.constants = {tensor("full", {2, 3}, std::vector<float>{1, 2, 3, 4, 5, 6})};
  lower.input = {2, 3};
  EXPECT_THAT(values_of(lower, std::vector<float>(6, 0)), ElementsAre(1, 0, 0, 4, 5, 0));
  ranges.nodes[0] = layer("Range", {"zero", "three", "zero"}, {"places"});
  EXPECT_ERROR(load(onnx(ranges)), "its step is 0");
}

// Steps that lead beyond 64 bits on the way.
TEST(Operators, RangesOfLargeNumbers) {
  constexpr std::int64_t kFar = 9'000'000'000'000'000'000;
  const TinyGraph graph{
      {layer("Range", {"first", "end", "step"}, {"far"}), layer("Div", {"far", "unit"}, {"near"}),
       layer("Cast", {"near"}, {"numbers"}, {attribute("to", 1)}),
       layer("Add", {"picture", "numbers"}, {"out"})},
      {tensor("first", {}, Integers{-kFar}), tensor("end", {}, Integers{kFar}),
       tensor("step", {}, Integers{kFar / 3 * 2}), tensor("unit", {}, Integers{kFar / 3})},
      {3},
      {{"out", {}}}};
  EXPECT_THAT(values_of(graph, {0, 0, 0}), ElementsAre(-3, -1, 1));
}

TEST(Operators, Expansions) {
  const auto expand = [](Integers shape) {
    return one_node("Expand", {1, 2, 1}, {}, {"s"},
                    {tensor("s", {static_cast<std::int64_t>(shape.size())}, shape)});
  };
  EXPECT_THAT(values_of(expand({2, 1, 2}), {3, 4}), ElementsAre(3, 3, 4, 4, 3, 3, 4, 4));
  EXPECT_THAT(shape_of(expand({2, 1, 1, 1})), ElementsAre(2, 1, 2, 1));
  EXPECT_ERROR(load(onnx(expand({1, 3, 1}))), "do not fit each other");
}

TEST(Operators, PartsOfShapes) {
  TinyGraph graph{
      {layer("Shape", {"picture"}, {"part"}, {attribute("start", 1), attribute("end", -1)}),
       layer("Cast", {"part"}, {"numbers"}, {attribute("to", 1)}),
       layer("Add", {"picture", "numbers"}, {"out"})},
      {},
      {1, 2, 1},
      {{"out", {}}}};
  graph.opset = 15;
  EXPECT_THAT(values_of(graph, {0, 1}), ElementsAre(2, 3));
}

TEST(Operators, ProductsOfManyMatrices) {
  const TinyGraph weighted = one_node("MatMul", {2, 2, 1, 2}, {}, {"w"},
                                      {tensor("w", {2, 2}, std::vector<float>{1, 10, 100, 1000})});
  EXPECT_THAT(shape_of(weighted), ElementsAre(2, 2, 1, 2));
  EXPECT_THAT(values_of(weighted, {1, 2, 3, 4, 5, 6, 7, 8}),
              ElementsAre(201, 2010, 403, 4030, 605, 6050, 807, 8070));
  const TinyGraph each{
      {layer("Transpose", {"picture"}, {"t"}, {attribute("perm", Integers{0, 2, 1})}),
       layer("MatMul", {"picture", "t"}, {"out"})},
      {},
      {2, 1, 2},
      {{"out", {}}}};
  EXPECT_THAT(values_of(each, {1, 2, 3, 4}), ElementsAre(5, 25));
}

TEST(Operators, ErrorsNameNodeOperatorAndOpset) {
  EXPECT_ERROR(load(onnx(one_node("LSTM", {1, 3}))),
               "node \"out_node\" (LSTM, opset 11): the operator is not supported");
  TinyGraph foreign = one_node("Relu", {1, 3});
  foreign.nodes[0] += roomwise::testing::field(7, std::string("com.example"));
  EXPECT_ERROR(load(onnx(foreign)), "not supported (of \"com.example\")");
  EXPECT_ERROR(
      load(onnx(one_node("Conv", {1, 3, 8, 8}, {}, {"w"}, {random_weights("w", {4, 2, 3, 3}, 1)}))),
      "node \"out_node\" (Conv, opset 11): its weights 4x2x3x3 do not fit its input "
      "1x3x8x8 in 1 groups");
  EXPECT_ERROR(load(onnx(one_node("Add", {1, 3}, {}, {"nowhere"}))),
               "nothing before it gives \"nowhere\"");
  TinyGraph future = one_node("Relu", {1, 3});
  future.opset = 18;
  EXPECT_ERROR(load(onnx(future)), "opset 18; 10 to 17 are understood");
}

}  // namespace
}  // namespace roomwise::network
