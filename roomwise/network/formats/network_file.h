#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "roomwise/network/formats/eight_bit_file.h"
#include "roomwise/network/formats/model_card.h"
#include "roomwise/network/graph/onnx_graph.h"

namespace roomwise::network {

// A network as its files say it: the weights, the card, the labels.
struct NetworkFile {
  ModelCard card;
  std::vector<std::string> labels;  // empty: it names nothing
  OnnxGraph graph;                  // its input is of the card's size
  std::string sha256;               // of the weights file
  // By which a home knows what it saw: that SHA-256; with a card of one's own (ModelCard::own) a
  // digest of that, the card and the labels; or EightBitFile's.
  std::string fingerprint;
  std::optional<EightBitFile> eight_bits = std::nullopt;  // absent: it is run in floats
};

// Whether it ends as files of networks, or of weights alone, do: .onnx, .pth, .safetensors. One of
// 8 bits is neither.
[[nodiscard]] bool has_ending_of_network(const std::filesystem::path& file);

// NetworkFile::fingerprint of a network that is run in floats.
[[nodiscard]] std::string network_fingerprint(const std::string& sha256, const ModelCard& card,
                                              const std::vector<std::string>& labels);

// weights: an ONNX file, weights alone (weights_file.h) of the network that the card names, or a
// file that says how one of these is run in 8 bits (eight_bit_file.h), which then has a name of its
// own. labels: a text file, one label a line; absent: the one that the card names, if any. Fails
// where a file is missing or is not what it should be, where weights are not finite
// (check_weights()), and where the network does not take colour pictures of the card's size.
[[nodiscard]] Expected<NetworkFile> read_network_file(
    const std::filesystem::path& weights, const std::optional<std::filesystem::path>& labels);

// What a network can name, without its weights. Fails where the card or the labels are missing.
[[nodiscard]] Expected<std::vector<std::string>> read_labels_of(
    const std::filesystem::path& weights);

// As read_network_file(), for what runs networks in floats only; fails on a file of 8 bits, too.
[[nodiscard]] Expected<NetworkFile> read_network_in_floats(
    const std::filesystem::path& weights,
    const std::optional<std::filesystem::path>& labels = std::nullopt);

// A network that was read in floats, to be run in 8 bits like this. Fails where `how` was measured
// with another file.
[[nodiscard]] Expected<NetworkFile> in_eight_bits(NetworkFile file, EightBitFile how);

// One label a line; the last line may lack its end. Labels may repeat (ImageNet has two cranes).
// Fails on an empty file and on an empty line.
[[nodiscard]] Expected<std::vector<std::string>> read_labels(const std::filesystem::path& path);

}  // namespace roomwise::network
