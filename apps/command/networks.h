#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "command.h"
#include "roomwise/network/formats/catalogue.h"
#include "roomwise/objects/proposals/object_finders.h"
#include "roomwise/pipeline/objects/keyframe_observer.h"
#include "roomwise/pipeline/stored/network_precision.h"

namespace roomwise::network {
class OpenVocabulary;
}

namespace roomwise::app {

// The networks that the user names on the command line.
struct NetworkOptions {
  std::vector<std::filesystem::path> files;
  std::optional<std::filesystem::path> labels;
  pipeline::NetworkPrecision precision = pipeline::NetworkPrecision::kAuto;
};

// Declares --network-precision.
void add_precision_option(CLI::App& command, NetworkOptions& options);
// Declares --network (any number), --labels and --network-precision.
void add_network_options(CLI::App& command, NetworkOptions& options);

// Loads them as they look at this home's pictures; where none is named, usable_networks(). May be
// none. `home`: nullptr for one that is to be made.
// `also_brought`: the compact network too, after the others, for a home that may have been learned
// with it before they were installed.
[[nodiscard]] Expected<pipeline::Networks> load_networks(const NetworkOptions& options,
                                                         const home::Home* home,
                                                         bool also_brought = false);

// The same before they look at pictures of the home for the first time: those that may then look in
// 8 bits are checked on these pictures, which the home remembers, and a line says what came of it.
[[nodiscard]] Expected<pipeline::Networks> load_networks_for_new(const NetworkOptions& options,
                                                                 home::Home& home,
                                                                 std::size_t pictures,
                                                                 const network::PictureAt& picture,
                                                                 Context& context);
// By the pictures of its key-frames.
[[nodiscard]] Expected<pipeline::Networks> load_networks_for_keyframes(
    const NetworkOptions& options, home::Home& home, Context& context);
// A key-frame's picture, by its place among all; errors name the home and the key-frame.
[[nodiscard]] network::PictureAt pictures_of_keyframes(const home::Home& home,
                                                       std::vector<home::Keyframe> keyframes);

// The finders: the detectors of the folders of networks, whatever --network names, and, beside
// them, the smallest classifier there that names things: with the first detector it is shown what
// stands apart in depth. None where there is no detector.
[[nodiscard]] Expected<objects::ObjectFinders> load_object_finders();

// Where "networks pull" puts files: $XDG_DATA_HOME/roomwise/networks, else
// ~/.local/share/roomwise/networks. Fails where neither is known.
[[nodiscard]] Expected<std::filesystem::path> own_network_folder();

// Where networks are looked for, the first that has a file first: the default model folder
// (ROOMWISE_MODELS), then the user's own. Only folders that are there.
[[nodiscard]] std::vector<std::filesystem::path> network_folders();

// The folder of networks that come with Roomwise: share/roomwise/networks beside the program's
// folder, or beside one above the Python package's.
[[nodiscard]] std::optional<std::filesystem::path> brought_network_folder();

// The networks of network_folders() that look at whole pictures, by their cards, in the order of
// folders, by name; where there are none, those that come with Roomwise.
[[nodiscard]] Expected<std::vector<std::filesystem::path>> usable_networks();
// The detectors of these folders, which look at every key-frame. Of those with the same labels one
// alone, since two find no more than the better one, in twice the time: NanoDet-Plus, which the
// model of objects was fitted with, else the largest.
[[nodiscard]] Expected<std::vector<std::filesystem::path>> usable_detectors();

// Those of the folders that compare pictures with words; the first is used.
[[nodiscard]] Expected<std::vector<std::filesystem::path>> usable_word_networks();
// The first. Fails where there is none, saying what to put where.
[[nodiscard]] Expected<std::unique_ptr<network::OpenVocabulary>> load_open_vocabulary();

// All files of networks of the folders, that of Roomwise last; of two files of one name the first.
[[nodiscard]] std::vector<std::filesystem::path> installed_networks();

// The entry of the catalogue of this name, or of a file of this name; or nullptr.
[[nodiscard]] const network::CatalogueEntry* find_catalogue_entry(const std::string& name);

// FILE in the first folder of networks that has it; that of Roomwise is the last.
[[nodiscard]] std::optional<std::filesystem::path> find_in_folders(const std::string& file);

// A network's file by what the user calls it: a name of the catalogue, a file of the folders of
// networks with or without its ending, or a path. Fails where it is not here, saying how to get it.
[[nodiscard]] Expected<std::filesystem::path> find_network_file(const std::string& name);

}  // namespace roomwise::app
