// Networks of CLIP's kind: as PyTorch exports them, against what it says they give.
#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <numeric>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/network/formats/onnx_writer.h"
#include "roomwise/network/testing/tiny_runs.h"

namespace roomwise::network {
namespace {

namespace fs = std::filesystem;
using namespace testing;

std::vector<float> floats_in(const fs::path& file) {
  const Bytes bytes = read_file(file).value();
  std::vector<float> floats(bytes.size() / sizeof(float));
  std::memcpy(floats.data(), bytes.data(), floats.size() * sizeof(float));
  return floats;
}

// The inputs that lie one after the other in a file, for as many rows as it has.
std::vector<Tensor> inputs_in(const fs::path& file, const std::vector<GraphInput>& wanted) {
  const std::vector<float> values = floats_in(file);
  std::vector<Tensor> inputs;
  std::size_t in_row = 0;
  for (const GraphInput& input : wanted) {
    Tensor& tensor = inputs.emplace_back(Tensor{input.shape, {}});
    tensor.shape.front() = 1;
    in_row += element_count(tensor.shape);
  }
  auto from = values.begin();
  for (Tensor& tensor : inputs) {
    tensor.shape.front() = static_cast<std::int64_t>(values.size() / in_row);
    const auto count = static_cast<std::ptrdiff_t>(element_count(tensor.shape));
    tensor.values.assign(from, from + count);
    from += count;
  }
  return inputs;
}

TEST(ClipByPyTorch, GivesWhatPyTorchGives) {
  if (std::system("/usr/bin/python3 -c 'import torch.onnx' >/dev/null 2>&1") != 0)
    GTEST_SKIP() << "python3-torch is not installed";
  const roomwise::testing::ScratchFolder folder;
  const std::string command = fmt::format("/usr/bin/python3 '{}' '{}' >/dev/null 2>&1",
                                          ROOMWISE_TORCH_CLIP, folder.path().string());
  ASSERT_EQ(std::system(command.c_str()), 0);
  int compared = 0;
  for (const auto& entry : fs::directory_iterator(folder.path())) {
    if (entry.path().extension() != ".onnx") continue;
    SCOPED_TRACE(entry.path().filename());
    const Bytes file = read_file(entry.path()).value();
    auto graph = read_onnx_graph(file);
    ASSERT_OK(graph);
    const auto executor = Executor::create(std::move(*graph));
    ASSERT_OK(executor);
    const auto inputs =
        inputs_in(fs::path(entry.path()).replace_extension("input"), (*executor)->inputs());
    const auto outputs = (*executor)->run(inputs);
    ASSERT_OK(outputs);
    const auto expected = floats_in(fs::path(entry.path()).replace_extension("expected"));
    EXPECT_LT(relative_error(outputs->front().values, expected), 1e-4);
    ++compared;
  }
  EXPECT_EQ(compared, 12);
}

// One block of a text network, with weights by seed, written down as an ONNX graph and worked out
// by loops: words and places, causal attention of two heads, QuickGELU, the end of the text.
class TextBlock {
 public:
  static constexpr std::size_t kWords = 12, kPlaces = 5, kWidth = 6, kHeads = 2, kHidden = 8,
                               kOut = 4;

  TextBlock() {
    graph_.opset = 14;
    graph_.inputs = {{"tokens", {1, kPlaces}, true}};
    graph_.outputs = {"embedding"};
    add_weights("words", {kWords, kWidth});
    add_weights("places", {kPlaces, kWidth});
    for (const char* name : {"query", "key", "value", "out"}) add_weights(name, {kWidth, kWidth});
    add_weights("widen", {kWidth, kHidden});
    add_weights("narrow", {kHidden, kWidth});
    add_weights("projection", {kWidth, kOut});
    add_numbers("full", {kPlaces, kPlaces},
                std::vector<float>(kPlaces * kPlaces, -std::numeric_limits<float>::infinity()));
    add_numbers("two", {}, {2});
    add_numbers("epsilon", {}, {1e-5F});
    add_numbers("scale", {}, {1 / std::sqrt(static_cast<float>(kWidth / kHeads))});
    add_numbers("quick", {}, {1.702F});
    add_integers("one", {}, {1});
    add_integers("split", {4}, {1, kPlaces, kHeads, kWidth / kHeads});
    add_integers("joined", {3}, {1, kPlaces, kWidth});
  }

  [[nodiscard]] Expected<std::vector<Tensor>> run(const std::vector<float>& tokens) {
    if (graph_.nodes.empty()) build();
    ROOMWISE_TRY(const Bytes file, write_onnx_graph(graph_));
    ROOMWISE_TRY(OnnxGraph graph, read_onnx_graph(file));
    ROOMWISE_TRY(const auto executor, Executor::create(std::move(graph)));
    return executor->run(std::vector{Tensor{{1, kPlaces}, tokens}});
  }

  [[nodiscard]] std::vector<float> by_loops(const std::vector<float>& tokens) const {
    Rows x(kPlaces, Row(kWidth));
    for (std::size_t place = 0; place < kPlaces; ++place) {
      for (std::size_t i = 0; i < kWidth; ++i)
        x[place][i] = weight("words", static_cast<std::size_t>(tokens[place]), i) +
                      weight("places", place, i);
    }
    const Rows normal = normalized(x);
    const Rows query = times(normal, "query"), key = times(normal, "key"),
               value = times(normal, "value");
    constexpr std::size_t kSize = kWidth / kHeads;
    Rows attended(kPlaces, Row(kWidth));
    for (std::size_t head = 0; head < kHeads; ++head) {
      for (std::size_t place = 0; place < kPlaces; ++place) {
        double sum = 0;
        Row shares;
        for (std::size_t earlier = 0; earlier <= place; ++earlier) {
          double product = 0;
          for (std::size_t i = head * kSize; i < (head + 1) * kSize; ++i)
            product += query[place][i] * key[earlier][i];
          shares.push_back(std::exp(product / std::sqrt(static_cast<double>(kSize))));
          sum += shares.back();
        }
        for (std::size_t earlier = 0; earlier <= place; ++earlier) {
          for (std::size_t i = head * kSize; i < (head + 1) * kSize; ++i)
            attended[place][i] += shares[earlier] / sum * value[earlier][i];
        }
      }
    }
    x = plus(x, times(attended, "out"));
    Rows hidden = times(normalized(x), "widen");
    for (Row& row : hidden) {
      for (double& each : row) each /= 1 + std::exp(-1.702 * each);
    }
    x = normalized(plus(x, times(hidden, "narrow")));
    const auto end = static_cast<std::size_t>(std::ranges::max_element(tokens) - tokens.begin());
    const Row embedding = times({x[end]}, "projection").front();
    double squares = 0;
    for (const double each : embedding) squares += each * each;
    std::vector<float> unit;
    for (const double each : embedding)
      unit.push_back(static_cast<float>(each / std::sqrt(squares)));
    return unit;
  }

 private:
  using Row = std::vector<double>;
  using Rows = std::vector<Row>;

  void add_numbers(const std::string& name, Shape shape, std::vector<float> values) {
    graph_.constants[name] =
        std::make_shared<const Constant>(Constant{std::move(shape), false, std::move(values), {}});
  }
  void add_integers(const std::string& name, Shape shape, std::vector<std::int64_t> values) {
    graph_.constants[name] =
        std::make_shared<const Constant>(Constant{std::move(shape), true, {}, std::move(values)});
  }
  void add_weights(const std::string& name, const Shape& shape) {
    add_numbers(name, shape, random_values(element_count(shape), graph_.constants.size() + 1));
  }

  std::string node(const char* operation, const std::string& name, std::vector<std::string> inputs,
                   std::map<std::string, Attribute> attributes = {}) {
    graph_.nodes.push_back({name, operation, "", std::move(inputs), {name}, std::move(attributes)});
    return name;
  }
  // As exporters before opset 17 write it, without scales and shifts.
  std::string normal_node(const std::string& from, const std::string& name) {
    const std::map<std::string, Attribute> last{{"axes", Attribute(std::vector<std::int64_t>{-1})}};
    node("ReduceMean", name + ".mean", {from}, last);
    node("Sub", name + ".centered", {from, name + ".mean"});
    node("Pow", name + ".squares", {name + ".centered", "two"});
    node("ReduceMean", name + ".variance", {name + ".squares"}, last);
    node("Add", name + ".raised", {name + ".variance", "epsilon"});
    node("Sqrt", name + ".deviation", {name + ".raised"});
    return node("Div", name, {name + ".centered", name + ".deviation"});
  }
  std::string head_node(const std::string& from, const std::string& weights,
                        std::vector<std::int64_t> axes) {
    node("MatMul", weights + ".all", {from, weights});
    node("Reshape", weights + ".heads", {weights + ".all", "split"});
    return node("Transpose", weights + ".first", {weights + ".heads"},
                {{"perm", Attribute(std::move(axes))}});
  }

  void build() {
    node("Gather", "word", {"words", "tokens"});
    node("Add", "x", {"word", "places"});
    normal_node("x", "before");
    const std::string query = head_node("before", "query", {0, 2, 1, 3});
    const std::string key = head_node("before", "key", {0, 2, 3, 1});
    const std::string value = head_node("before", "value", {0, 2, 1, 3});
    node("MatMul", "products", {query, key});
    node("Mul", "scaled", {"products", "scale"});
    node("Trilu", "mask", {"full", "one"});
    node("Add", "masked", {"scaled", "mask"});
    node("Softmax", "shares", {"masked"}, {{"axis", Attribute(std::int64_t{-1})}});
    node("MatMul", "attended", {"shares", value});
    node("Transpose", "back", {"attended"},
         {{"perm", Attribute(std::vector<std::int64_t>{0, 2, 1, 3})}});
    node("Reshape", "together", {"back", "joined"});
    node("MatMul", "mixed", {"together", "out"});
    node("Add", "y", {"x", "mixed"});
    normal_node("y", "between");
    node("MatMul", "wide", {"between", "widen"});
    node("Mul", "quicker", {"wide", "quick"});
    node("Sigmoid", "gate", {"quicker"});
    node("Mul", "hidden", {"wide", "gate"});
    node("MatMul", "narrowed", {"hidden", "narrow"});
    node("Add", "z", {"y", "narrowed"});
    normal_node("z", "after");
    node("ArgMax", "end", {"tokens"},
         {{"axis", Attribute(std::int64_t{-1})}, {"keepdims", Attribute(std::int64_t{0})}});
    node("Flatten", "rows", {"after"}, {{"axis", Attribute(std::int64_t{2})}});
    node("Gather", "last", {"rows", "end"});
    node("MatMul", "projected", {"last", "projection"});
    node("ReduceL2", "length", {"projected"}, {{"axes", Attribute(std::vector<std::int64_t>{-1})}});
    node("Div", "embedding", {"projected", "length"});
  }

  [[nodiscard]] double weight(const std::string& name, std::size_t row, std::size_t column) const {
    const Constant& constant = *graph_.constants.at(name);
    return constant.floats[row * static_cast<std::size_t>(constant.shape[1]) + column];
  }
  [[nodiscard]] Rows times(const Rows& rows, const std::string& name) const {
    const Shape& shape = graph_.constants.at(name)->shape;
    Rows result;
    for (const Row& row : rows) {
      Row product(static_cast<std::size_t>(shape[1]), 0);
      for (std::size_t i = 0; i < row.size(); ++i) {
        for (std::size_t j = 0; j < product.size(); ++j) product[j] += row[i] * weight(name, i, j);
      }
      result.push_back(std::move(product));
    }
    return result;
  }
  [[nodiscard]] static Rows plus(Rows a, const Rows& b) {
    for (std::size_t i = 0; i < a.size(); ++i) {
      for (std::size_t j = 0; j < a[i].size(); ++j) a[i][j] += b[i][j];
    }
    return a;
  }
  [[nodiscard]] static Rows normalized(Rows rows) {
    for (Row& row : rows) {
      const auto count = static_cast<double>(row.size());
      const double mean = std::accumulate(row.begin(), row.end(), 0.0) / count;
      double variance = 0;
      for (const double each : row) variance += (each - mean) * (each - mean) / count;
      for (double& each : row) each = (each - mean) / std::sqrt(variance + 1e-5);
    }
    return rows;
  }

  OnnxGraph graph_;
};

TEST(ClipInLoops, ATextNetworkGivesWhatLoopsGive) {
  TextBlock block;
  for (const std::vector<float>& tokens :
       {std::vector<float>{10, 3, 11, 0, 0}, {10, 7, 5, 2, 11}}) {
    const auto outputs = block.run(tokens);
    ASSERT_OK(outputs);
    EXPECT_LT(relative_error(outputs->front().values, block.by_loops(tokens)), 1e-5);
  }
  // What comes after the end of the text does not count.
  EXPECT_EQ(block.run({10, 3, 11, 0, 0})->front().values,
            block.run({10, 3, 11, 4, 9})->front().values);
  EXPECT_NE(block.run({10, 3, 11, 0, 0})->front().values,
            block.run({10, 4, 11, 0, 0})->front().values);
  EXPECT_ERROR(block.run({10, 12, 11, 0, 0}), "node \"word\": there is no index 12 among 12");
}

}  // namespace
}  // namespace roomwise::network
