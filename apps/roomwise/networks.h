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

// Loads them; where none is named, those of the default model folder that Roomwise has a card for.
// May be none.
[[nodiscard]] Expected<pipeline::Networks> load_networks(const NetworkOptions& options);

}  // namespace roomwise::app
