#include <algorithm>
#include <filesystem>
#include <iterator>
#include <vector>

#include "commands.h"
#include "networks.h"
#include "open_home.h"
#include "roomwise/pipeline/stored/network_files.h"

namespace roomwise::app {
namespace {

using pipeline::NeededNetwork;
using pipeline::NetworkFileState;

struct CheckOptions {
  std::filesystem::path home;
  std::vector<std::filesystem::path> networks;
};

std::vector<home::KeyframeId> keyframes_of(const home::HomeCheck& check) {
  std::vector<home::KeyframeId> ids;
  for (const auto& [id, why] : check.lost_pictures) ids.push_back(id);
  return ids;
}

// Of a damaged home it may not be known which networks it needs.
Expected<std::vector<NeededNetwork>> check_networks(const home::Home& home,
                                                    const home::HomeCheck& check,
                                                    const CheckOptions& options) {
  std::vector<std::filesystem::path> files = options.networks;
  std::ranges::copy(installed_networks(), std::back_inserter(files));
  auto networks = pipeline::check_network_files(home, files);
  if (!networks && !check.is_whole()) return std::vector<NeededNetwork>();
  return networks;
}

Json json_of(const std::vector<NeededNetwork>& networks) {
  Json json = Json::array();
  for (const NeededNetwork& one : networks) {
    json.push_back({{"name", one.name},
                    {"state", pipeline::name_of(one.state)},
                    {"sha256", one.sha256},
                    {"file", one.file.empty() ? Json() : Json(one.file.string())}});
  }
  return json;
}

std::string for_people(const home::Home& home, const home::HomeCheck& check,
                       const std::vector<NeededNetwork>& networks) {
  std::string text =
      fmt::format("{}: {}\n", home.file(), check.is_whole() ? "is whole" : "is damaged");
  const auto line = [&](const std::string& what) { text += "  " + what + "\n"; };
  if (!check.damaged_pages.empty()) {
    line(fmt::format("{} of its {} pages differ from their checksums", check.damaged_pages.size(),
                     check.pages));
  }
  for (const std::string& table : check.damaged_tables)
    line(fmt::format("table '{}' cannot be read in full", table));
  if (!check.lost_pictures.empty()) {
    line(fmt::format("the images of {} key-frames cannot be read: {}", check.lost_pictures.size(),
                     fmt::join(keyframes_of(check), ", ")));
  }
  if (!check.lost_own_things.empty()) {
    line(fmt::format("the pictures of {} things that people taught cannot be read",
                     check.lost_own_things.size()));
  }
  for (const std::string& table : check.broken_references)
    line(fmt::format("a row of table '{}' belongs to one that is not there", table));
  for (const std::string& camera : check.doubtful_cameras)
    line(fmt::format("note: the camera of {}", camera));
  if (home.is_locked()) {
    line(
        "note: whether its sealed pictures were changed was not looked at; give "
        "--passphrase-file");
  }
  for (const NeededNetwork& network : networks) {
    if (network.state == NetworkFileState::kRight) continue;
    const bool is_damaged = network.state == NetworkFileState::kDamaged;
    line((is_damaged ? "" : "note: ") + in_words(network));
  }
  if (!check.is_whole()) {
    line(
        "put back a copy of it (roomwise restore); what is not named above is whole, and of a copy "
        "of this file can be read with: sqlite3 COPY .recover");
  }
  return text;
}

Expected<Answer> check(const CheckOptions& options, Context& context) {
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  ROOMWISE_TRY(const home::HomeCheck found, home.check());
  ROOMWISE_TRY(const auto networks, check_networks(home, found, options));
  const bool is_network_damaged = std::ranges::find(networks, NetworkFileState::kDamaged,
                                                    &NeededNetwork::state) != networks.end();
  return Answer{for_people(home, found, networks),
                {{"home", home.file()},
                 {"whole", found.is_whole()},
                 {"pages", found.pages},
                 {"damaged_pages", found.damaged_pages},
                 {"damaged_tables", found.damaged_tables},
                 {"lost_pictures", keyframes_of(found)},
                 {"lost_own_things", found.lost_own_things.size()},
                 {"broken_references", found.broken_references},
                 {"doubtful_cameras", found.doubtful_cameras},
                 {"seals_checked", home.is_protected() && !home.is_locked()},
                 {"networks", json_of(networks)}},
                found.is_whole() && !is_network_damaged};
}

}  // namespace

void add_check_command(CLI::App& app, Context& context) {
  const auto [command, options] = add_command<CheckOptions>(
      app, context, "check",
      "Read a home's whole file, pictures too, and the files of the networks that it was made "
      "with, and say what of it is damaged; the exit code is 1 where something is",
      "roomwise check my.home", check);
  command->add_option("HOME", options.home, "Home file")->required();
  command
      ->add_option("--network", options.networks,
                   "A network's file that lies in no folder of networks. May be given several "
                   "times")
      ->check(CLI::ExistingFile);
}

}  // namespace roomwise::app
