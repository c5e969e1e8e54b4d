#include "roomwise/network/network_file.h"

#include <algorithm>

#include "roomwise/base/file.h"

namespace roomwise::network {
namespace {

// That the network takes one colour picture of the card's size.
// Sizes that it leaves open are the card's from here on.
Expected<void> fix_input(OnnxGraph& graph, const ModelCard& card) {
  if (graph.inputs.size() != 1) {
    return fail("the network has {} inputs; expected one, a colour picture", graph.inputs.size());
  }
  GraphInput& input = graph.inputs.front();
  const Shape expected{1, 3, card.input_height_px, card.input_width_px};
  const auto fits = [](std::int64_t given, std::int64_t wanted) {
    return given == GraphInput::kFree || given == wanted;
  };
  if (!std::ranges::equal(input.shape, expected, fits)) {
    return fail(
        "the network does not take a colour picture as its card says: its input \"{}\" has the "
        "shape {}; expected {} (batch x channels x height x width)",
        input.name, shape_text(input.shape), shape_text(expected));
  }
  input.shape = expected;
  return {};
}

Expected<std::vector<std::string>> labels_for(const ModelCard& card,
                                              const std::filesystem::path& weights,
                                              const std::optional<std::filesystem::path>& labels) {
  if (labels) return read_labels(*labels);
  if (card.labels_file.empty()) return std::vector<std::string>{};
  const std::filesystem::path beside = weights.parent_path() / card.labels_file;
  std::error_code ignored;
  if (!std::filesystem::exists(beside, ignored)) {
    return fail("{}: its labels are missing; put {} there or name the file with its labels",
                weights.string(), beside.string());
  }
  return read_labels(beside);
}

}  // namespace

Expected<std::vector<std::string>> read_labels(const std::filesystem::path& path) {
  ROOMWISE_TRY(const std::string text, read_text_file(path));
  std::vector<std::string> labels;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string label = text.substr(begin, end - begin);
    if (label.ends_with('\r')) label.pop_back();
    begin = end + 1;
    if (label.empty()) {
      return fail("{}:{}: the line is empty; expected a label", path.string(), labels.size() + 1);
    }
    labels.push_back(std::move(label));
  }
  if (labels.empty()) return fail("{}: holds no label; expected one a line", path.string());
  return labels;
}

Expected<NetworkFile> read_network_file(const std::filesystem::path& weights,
                                        const std::optional<std::filesystem::path>& labels) {
  const auto in_file = [&](Error error) { return std::move(error).in(weights.string()); };
  NetworkFile file;
  ROOMWISE_TRY(const Bytes onnx, read_file(weights));
  ROOMWISE_TRY(file.card, find_model_card(weights));
  ROOMWISE_TRY(file.labels, labels_for(file.card, weights, labels));
  ROOMWISE_TRY(file.graph, read_onnx_graph(onnx).map_error(in_file));
  ROOMWISE_CHECK_OK(fix_input(file.graph, file.card).map_error(in_file));
  file.fingerprint = sha256_hex(onnx);
  return file;
}

}  // namespace roomwise::network
