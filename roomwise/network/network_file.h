#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "roomwise/network/model_card.h"
#include "roomwise/network/onnx_graph.h"

namespace roomwise::network {

// A network as its files say it: the weights, the card, the labels.
struct NetworkFile {
  ModelCard card;
  std::vector<std::string> labels;  // empty: it names nothing
  OnnxGraph graph;                  // its input is of the card's size
  std::string fingerprint;          // SHA-256 of the weights file
};

// Whether it ends as files of networks, or of weights alone, do: .onnx, .pth, .safetensors.
[[nodiscard]] bool has_ending_of_network(const std::filesystem::path& file);

// weights: an ONNX file, or weights alone (weights_file.h) of the network that the card names.
// labels: a text file, one label a line; absent: the one that the card names, if any. Fails where a
// file is missing or is not what it should be, and where the network does not take colour pictures
// of the card's size.
[[nodiscard]] Expected<NetworkFile> read_network_file(
    const std::filesystem::path& weights, const std::optional<std::filesystem::path>& labels);

// One label a line; the last line may lack its end. Labels may repeat (ImageNet has two cranes).
// Fails on an empty file and on an empty line.
[[nodiscard]] Expected<std::vector<std::string>> read_labels(const std::filesystem::path& path);

}  // namespace roomwise::network
