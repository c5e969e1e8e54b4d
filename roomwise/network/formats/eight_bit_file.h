#pragma once

#include <filesystem>
#include <string>

#include "roomwise/base/expected.h"
#include "roomwise/network/graph/eight_bit_ranges.h"

namespace roomwise::network {

// Says that a network is to be worked out in 8 bits, and how: NAME.eightbits, JSON. It stands for a
// network of its own, since what it gives differs a little:
//   { "network": "NAME.onnx", "sha256": "of that file", "preprocessing": "of its card",
//     "input": [1, 3, 299, 299], "min_channels": 1, "ranges": { "a layer": [0, 3.25], ... },
//     "checked": "for people: how near it came" }
struct EightBitFile {
  std::filesystem::path network;  // the weights file, from the folder of this one
  std::string sha256;             // its digest
  std::string preprocessing;      // Classifier::preprocessing() while it was measured
  EightBitRanges ranges;
  std::string checked;

  // A digest of all that tells what the network gives: not of where its weights lie.
  [[nodiscard]] std::string fingerprint() const;

  static constexpr const char* kEnding = ".eightbits";
};

[[nodiscard]] bool is_eight_bit_file(const std::filesystem::path& file);

// For people: of the network of this name.
[[nodiscard]] std::string name_in_eight_bits(const std::string& network);

// Fails, naming `origin` (the file) and the field, on anything missing, unknown or out of range.
[[nodiscard]] Expected<EightBitFile> parse_eight_bit_file(std::string_view json,
                                                          const std::string& origin);
[[nodiscard]] Expected<EightBitFile> read_eight_bit_file(const std::filesystem::path& file);
// Fails where a name in it is no UTF-8, which JSON asks for.
[[nodiscard]] Expected<std::string> text_of(const EightBitFile& file);

}  // namespace roomwise::network
