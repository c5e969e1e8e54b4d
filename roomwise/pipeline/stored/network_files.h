#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "roomwise/home/home.h"

namespace roomwise::pipeline {

enum class NetworkFileState {
  kRight,
  kMissing,
  kDamaged,  // some of its bytes were changed
  kOther,    // the file of another network of this name, or of a later one
};
// "right", "missing", "damaged", "other".
[[nodiscard]] std::string_view name_of(NetworkFileState state);

// A network that a home was made with, and what of it is here.
struct NeededNetwork {
  std::string name;    // as the home knows it
  std::string use;     // for people: what the home has of it
  std::string sha256;  // of its weights file, or NetworkFile::fingerprint
  NetworkFileState state = NetworkFileState::kMissing;
  std::filesystem::path file = {};  // empty: none of this name is here
  std::string found_sha256 = {};    // of that file
  std::string published_as = {};    // its name in the catalogue; empty: it is not there

  friend bool operator==(const NeededNetwork&, const NeededNetwork&) = default;
};

// Compares the weights files that are here with what the home stores of the networks and detectors
// that it was made with: of each name the last, the one that its rooms were learned with first. Of
// a network in 8 bits that of its weights. A file with other bytes is damaged where its card, the
// catalogue or the record of its download has the home's digest, or where it is no network.
[[nodiscard]] Expected<std::vector<NeededNetwork>> check_network_files(
    const home::Home& home, const std::vector<std::filesystem::path>& files);

// One line for people: what is wrong, and how to mend it.
[[nodiscard]] std::string in_words(const NeededNetwork& needed);

}  // namespace roomwise::pipeline
