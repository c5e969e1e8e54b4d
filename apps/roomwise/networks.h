#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <vector>

#include "roomwise/pipeline/keyframe_observer.h"

namespace roomwise::app {

// The networks that the user names on the command line.
struct NetworkOptions {
  std::vector<std::filesystem::path> files;
  std::optional<std::filesystem::path> labels;
};

// Declares --network (any number) and --labels.
void add_network_options(CLI::App& command, NetworkOptions& options);

// Loads them; where none is named, those of the folders of networks that Roomwise has a card for.
// May be none.
[[nodiscard]] Expected<pipeline::Networks> load_networks(const NetworkOptions& options);

// Where "networks pull" puts files: $XDG_DATA_HOME/roomwise/networks, else
// ~/.local/share/roomwise/networks. Fails where neither is known.
[[nodiscard]] Expected<std::filesystem::path> own_network_folder();

// Where networks are looked for, the first that has a file first: the default model folder
// (ROOMWISE_MODELS), then the user's own. Only folders that are there.
[[nodiscard]] std::vector<std::filesystem::path> network_folders();

// The networks of those folders that look at whole pictures, by their cards: those that
// load_networks() takes. In the order of folders, by name.
[[nodiscard]] Expected<std::vector<std::filesystem::path>> usable_networks();

}  // namespace roomwise::app
