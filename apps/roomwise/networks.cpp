#include "networks.h"

#include <algorithm>

#include "roomwise/network/network_file.h"
#include "roomwise/network/onnx_classifier.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

// The networks of a folder that look at whole pictures, by their cards; by name.
Expected<std::vector<fs::path>> list_networks(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    if (!network::has_ending_of_network(entry->path())) continue;
    const auto card = network::find_model_card(entry->path());
    if (card && card->task == network::Task::kClassify) files.push_back(entry->path());
  }
  if (error)
    return fail("{}: the folder of networks (ROOMWISE_MODELS) cannot be read: {}", folder.string(),
                error.message());
  std::ranges::sort(files);
  return files;
}

}  // namespace

void add_network_options(CLI::App& command, NetworkOptions& options) {
  command.add_option("--network", options.files,
                     "ONNX network, or weights (.pth, .safetensors) of a known one, with its card "
                     "NAME.card.json beside it; may be given several times. Without it: "
                     "those of ROOMWISE_MODELS, else of ../shared/models");
  command.add_option("--labels", options.labels,
                     "What the last --network can name, a label a line, in place of the card's");
}

Expected<pipeline::Networks> load_networks(const NetworkOptions& options) {
  if (options.labels && options.files.empty())
    return fail("--labels says what a --network can name; give that too");
  std::vector<fs::path> files = options.files;
  if (files.empty()) {
    if (const auto folder = network::default_model_folder()) {
      ROOMWISE_TRY(files, list_networks(*folder));
    }
  }
  pipeline::Networks networks;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const bool takes_labels = options.labels && i + 1 == files.size();
    ROOMWISE_TRY(auto loaded, network::OnnxClassifier::load(
                                  files[i], takes_labels ? options.labels : std::nullopt));
    networks.push_back(std::move(loaded));
  }
  return networks;
}

}  // namespace roomwise::app
