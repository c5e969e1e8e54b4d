#include "roomwise/network/formats/network_file.h"

#include <algorithm>

#include "roomwise/base/file.h"
#include "roomwise/network/formats/built_in_cards.h"
#include "roomwise/network/formats/safetensors.h"
#include "roomwise/network/formats/torch_checkpoint_reader.h"
#include "roomwise/network/graph/inception_v3.h"

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
    return given == GraphInput::kDynamic || given == wanted;
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

Expected<std::vector<std::string>> parse_labels(std::string_view text, const std::string& origin) {
  std::vector<std::string> labels;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string label(text.substr(begin, end - begin));
    if (label.ends_with('\r')) label.pop_back();
    begin = end + 1;
    if (label.empty())
      return fail("{}:{}: the line is empty; expected a label", origin, labels.size() + 1);
    labels.push_back(std::move(label));
  }
  if (labels.empty()) return fail("{}: holds no label; expected one a line", origin);
  return labels;
}

Expected<std::vector<std::string>> labels_for(const ModelCard& card,
                                              const std::filesystem::path& weights,
                                              const std::optional<std::filesystem::path>& labels) {
  if (labels) return read_labels(*labels);
  if (card.labels_file.empty()) return std::vector<std::string>{};
  const std::filesystem::path beside = weights.parent_path() / card.labels_file;
  std::error_code ignored;
  if (!std::filesystem::exists(beside, ignored)) {
    const auto known = std::ranges::find(built_in_labels(), card.labels_file, &BuiltInText::name);
    if (known != built_in_labels().end()) return parse_labels(known->text, card.labels_file);
    return fail("{}: its labels are missing; put {} there or name the file with its labels",
                weights.string(), beside.string());
  }
  return read_labels(beside);
}

// Without the first ones, which the card says to leave out.
Expected<std::vector<std::string>> known_labels(const ModelCard& card,
                                                std::vector<std::string> all) {
  const auto unknown = static_cast<std::size_t>(card.first_label);
  if (unknown > 0 && unknown >= all.size()) {
    return fail("first_label: the labels begin with line {}, but there are only {}", unknown,
                all.size());
  }
  all.erase(all.begin(), all.begin() + card.first_label);
  return all;
}

// As many classes as the weights' last layer has.
Expected<OnnxGraph> inception_from(const Weights& weights) {
  InceptionOptions options;
  const auto last = weights.find("fc.weight");
  if (last != weights.end()) {
    const Shape& shape = last->second->shape;
    constexpr std::int64_t kFeatures = 2048;
    if (shape.size() != 2 || shape[0] < 1 || shape[1] != kFeatures)
      return fail("its \"fc.weight\" is {}, not classes x {}", shape_text(shape), kFeatures);
    options.classes = shape[0];
  }
  OnnxGraph graph = inception_v3(options);
  ROOMWISE_RETURN_IF_ERROR(apply_weights(graph, weights));
  return graph;
}

Expected<OnnxGraph> graph_of(const ModelCard& card, std::span<const std::uint8_t> bytes) {
  if (card.architecture == Architecture::kInceptionV3) {
    ROOMWISE_TRY(const Weights weights, read_weights(bytes));
    return inception_from(weights);
  }
  if (is_torch_checkpoint(bytes) || is_safetensors(bytes)) {
    return fail(
        "holds weights alone; say in its card of which network they are: \"architecture\": "
        "\"inception-v3\"");
  }
  return read_onnx_graph(bytes);
}

// The network that the file of 8 bits names.
Expected<NetworkFile> read_in_eight_bits(const std::filesystem::path& path,
                                         const std::optional<std::filesystem::path>& labels) {
  ROOMWISE_TRY(EightBitFile how, read_eight_bit_file(path));
  const std::filesystem::path weights = path.parent_path() / how.network;
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(weights, ignored)) {
    return fail("{}: is of the network {}, which is not there; put it there, or measure it anew",
                path.string(), weights.string());
  }
  ROOMWISE_TRY(NetworkFile file,
               read_network_in_floats(weights, labels).map_error([&](Error error) {
                 return std::move(error).with_context(path.string());
               }));
  return in_eight_bits(std::move(file), std::move(how)).map_error([&](Error error) {
    return std::move(error).with_context(path.string());
  });
}

}  // namespace

bool has_ending_of_network(const std::filesystem::path& file) {
  const std::filesystem::path ending = file.extension();
  return ending == ".onnx" || ending == ".pth" || ending == ".safetensors";
}

Expected<std::vector<std::string>> read_labels(const std::filesystem::path& path) {
  ROOMWISE_TRY(const std::string text, read_text_file(path));
  return parse_labels(text, path.string());
}

Expected<std::vector<std::string>> read_labels_of(const std::filesystem::path& weights) {
  ROOMWISE_TRY(const ModelCard card, find_model_card(weights));
  ROOMWISE_TRY(auto labels, labels_for(card, weights, std::nullopt));
  return known_labels(card, std::move(labels));
}

std::string network_fingerprint(const std::string& sha256, const ModelCard& card,
                                const std::vector<std::string>& labels) {
  if (card.own.empty()) return sha256;
  std::string all = fmt::format("{}\n{}", sha256, card.own);
  for (const std::string& label : labels) all += "\n" + label;  // each is a line
  return sha256_hex({reinterpret_cast<const std::uint8_t*>(all.data()), all.size()});
}

Expected<NetworkFile> read_network_file(const std::filesystem::path& weights,
                                        const std::optional<std::filesystem::path>& labels) {
  if (is_eight_bit_file(weights)) return read_in_eight_bits(weights, labels);
  return read_network_in_floats(weights, labels);
}

Expected<NetworkFile> in_eight_bits(NetworkFile file, EightBitFile how) {
  if (file.sha256 != how.sha256) {
    return fail("was measured of another file: the SHA-256 of {} is {}, not {}; measure it anew",
                how.network.string(), file.sha256, how.sha256);
  }
  file.card.name = name_in_eight_bits(file.card.name);
  file.fingerprint = how.fingerprint();
  file.eight_bits = std::move(how);
  return file;
}

Expected<NetworkFile> read_network_in_floats(const std::filesystem::path& weights,
                                             const std::optional<std::filesystem::path>& labels) {
  if (is_eight_bit_file(weights)) {
    return fail("{}: is for looking at whole pictures in 8 bits; give the network's own file here",
                weights.string());
  }
  const auto in_file = [&](Error error) { return std::move(error).with_context(weights.string()); };
  NetworkFile file;
  ROOMWISE_TRY(const Bytes bytes, read_file(weights));
  ROOMWISE_TRY(file.card, find_model_card(weights));
  file.sha256 = sha256_hex(bytes);
  if (!file.card.sha256.empty() && file.card.sha256 != file.sha256) {
    return fail("{}: is not the file that its card describes: its SHA-256 is {}, not {}",
                weights.string(), file.sha256, file.card.sha256);
  }
  ROOMWISE_TRY(auto all_labels, labels_for(file.card, weights, labels));
  ROOMWISE_TRY(file.labels, known_labels(file.card, std::move(all_labels)).map_error(in_file));
  file.fingerprint = network_fingerprint(file.sha256, file.card, file.labels);
  ROOMWISE_TRY(file.graph, graph_of(file.card, bytes).map_error(in_file));
  ROOMWISE_RETURN_IF_ERROR(check_weights(file.graph).map_error(in_file));
  ROOMWISE_RETURN_IF_ERROR(fix_input(file.graph, file.card).map_error(in_file));
  return file;
}

}  // namespace roomwise::network
