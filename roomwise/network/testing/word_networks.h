#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "roomwise/base/file.h"
#include "roomwise/base/random.h"
#include "roomwise/network/formats/onnx_writer.h"
#include "roomwise/network/graph/program.h"

// A pair of tiny networks that compare pictures with words, for tests.
namespace roomwise::network::testing {

// The first three numbers of an embedding are a picture's mean red, green and blue, from -1 to 1. A
// text's embedding is the mean of its pieces': "red", "green" and "blue" are these colours, every
// other letter is something by chance.
constexpr std::int64_t kWordNumbers = 8;
constexpr std::int64_t kWordPlaces = 16;
// Pieces 512 to 520, then the marks of begin and end.
constexpr const char* kWordMerges =
    "#version: 0.2\n"
    "e d</w>\nr ed</w>\n"
    "e e\nee n</w>\nr een</w>\ng reen</w>\n"
    "u e</w>\nl ue</w>\nb lue</w>\n";

inline Constant numbers(Shape shape, std::vector<float> values) {
  return {std::move(shape), false, std::move(values), {}};
}
inline Constant whole_numbers(std::vector<std::int64_t> values) {
  return {{static_cast<std::int64_t>(values.size())}, true, {}, std::move(values)};
}
inline ConstantPointer shared(Constant constant) {
  return std::make_shared<const Constant>(std::move(constant));
}

inline OnnxGraph picture_network_of_words() {
  OnnxGraph graph;
  graph.opset = 14;
  graph.inputs = {{"picture", {GraphInput::kDynamic, 3, 8, 8}}};
  graph.outputs = {"embedding"};
  std::vector<float> weights(static_cast<std::size_t>(3 * kWordNumbers), 0);
  for (std::size_t i = 0; i < 3; ++i) weights[i * static_cast<std::size_t>(kWordNumbers) + i] = 1;
  graph.constants["weights"] = shared(numbers({3, kWordNumbers}, std::move(weights)));
  graph.nodes = {{"pool", "GlobalAveragePool", "", {"picture"}, {"pooled"}, {}},
                 {"flat", "Flatten", "", {"pooled"}, {"means"}, {}},
                 {"widen", "MatMul", "", {"means", "weights"}, {"embedding"}, {}}};
  return graph;
}

inline OnnxGraph text_network_of_words() {
  constexpr std::size_t kPieces = 512 + 9 + 2;
  constexpr auto kNumbers = static_cast<std::size_t>(kWordNumbers);
  RandomStream random(1);
  std::vector<float> table(kPieces * kNumbers);
  for (float& value : table) value = static_cast<float>(random.normal());
  const auto set = [&](std::size_t piece, std::vector<float> row) {
    row.resize(kNumbers, 0);
    std::ranges::copy(row, table.begin() + static_cast<std::ptrdiff_t>(piece * kNumbers));
  };
  set(513, {1, -1, -1});  // red
  set(517, {-1, 1, -1});  // green
  set(520, {-1, -1, 1});  // blue
  for (const std::size_t nothing : {std::size_t{0}, kPieces - 2, kPieces - 1}) set(nothing, {});
  OnnxGraph graph;
  graph.opset = 14;
  graph.inputs = {{"input_ids", {GraphInput::kDynamic, GraphInput::kDynamic}, true}};
  graph.outputs = {"embedding"};
  graph.constants["table"] =
      shared(numbers({static_cast<std::int64_t>(kPieces), kWordNumbers}, std::move(table)));
  graph.nodes = {{"words", "Gather", "", {"table", "input_ids"}, {"rows"}, {}},
                 {"mean",
                  "ReduceMean",
                  "",
                  {"rows"},
                  {"embedding"},
                  {{"axes", Attribute(std::vector<std::int64_t>{1})},
                   {"keepdims", Attribute(std::int64_t{0})}}}};
  return graph;
}

constexpr const char* kWordCard = R"({
  "task": "match-words", "input": {"width": 8, "height": 8},
  "mean": [127.5, 127.5, 127.5], "scale": [0.00784, 0.00784, 0.00784],
  "text": {"network": "words-text.onnx", "merges": "words-merges.txt", "places": 16,
           "phrases": ["{}"]}})";

// words.onnx with its card, words-text.onnx and words-merges.txt.
inline Expected<void> write_word_networks(const std::filesystem::path& folder) {
  ROOMWISE_TRY(const Bytes pictures, write_onnx_graph(picture_network_of_words()));
  ROOMWISE_TRY(const Bytes texts, write_onnx_graph(text_network_of_words()));
  ROOMWISE_RETURN_IF_ERROR(write_file(folder / "words.onnx", pictures));
  ROOMWISE_RETURN_IF_ERROR(write_file(folder / "words-text.onnx", texts));
  ROOMWISE_RETURN_IF_ERROR(write_file(folder / "words-merges.txt", std::string(kWordMerges)));
  return write_file(folder / "words.card.json", std::string(kWordCard));
}

}  // namespace roomwise::network::testing
