#include "roomwise/pipeline/stored/network_files.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "roomwise/base/file.h"
#include "roomwise/network/formats/catalogue.h"
#include "roomwise/network/formats/network_file.h"
#include "roomwise/pipeline/stored/network_precision.h"

namespace roomwise::pipeline {
namespace {

namespace fs = std::filesystem;
using network::EightBitFile;

constexpr const char* kOfRooms = "with which its rooms were learned";
constexpr const char* kOfPictures = "which looked at its pictures";
constexpr const char* kOfThings = "which found its things";

// Rooms first; of the others the last of each name.
Expected<std::vector<NeededNetwork>> stored_networks(const home::Home& home) {
  std::vector<NeededNetwork> needed;
  const auto add = [&](const std::map<std::string, std::string>& last, const char* use) {
    for (const auto& [name, sha256] : last) {
      if (std::ranges::find(needed, sha256, &NeededNetwork::sha256) == needed.end())
        needed.push_back({.name = name, .use = use, .sha256 = sha256});
    }
  };
  ROOMWISE_TRY(const auto rooms, home.room_classifier());
  if (rooms) add({{rooms->network_name, rooms->network_fingerprint}}, kOfRooms);
  ROOMWISE_TRY(const auto networks, home.networks());
  std::map<std::string, std::string> last;
  for (const auto& [id, network] : networks) last[network.name] = network.fingerprint;
  add(last, kOfPictures);
  ROOMWISE_TRY(const auto finders, home.region_finders());
  last.clear();
  for (const auto& [id, finder] : finders) {
    if (objects::source_of(finder.fingerprint) == objects::DetectionSource::kDetector)
      last[finder.name] = finder.fingerprint;
  }
  add(last, kOfThings);
  return needed;
}

const network::CatalogueEntry* published(const NeededNetwork& needed) {
  for (const network::CatalogueEntry& entry : network::catalogue()) {
    if (!entry.sha256_begin.empty() && needed.sha256.starts_with(entry.sha256_begin)) return &entry;
    const auto card = network::find_model_card(entry.file);
    if (card && card->name == needed.name) return &entry;
  }
  return nullptr;
}

// Whether somebody says that a file of this name has these bytes.
bool is_said_of(const fs::path& file, const NeededNetwork& needed) {
  if (const auto card = network::find_model_card(file); card && card->sha256 == needed.sha256)
    return true;
  if (const auto record = read_text_file(file.string() + ".sha256");
      record && record->starts_with(needed.sha256))
    return true;
  return std::ranges::any_of(network::catalogue(), [&](const network::CatalogueEntry& entry) {
    return entry.file == file.filename() && !entry.sha256_begin.empty() &&
           needed.sha256.starts_with(entry.sha256_begin);
  });
}

// How the networks that are run in 8 bits are: what the home measured, and what files say.
Expected<std::vector<EightBitFile>> ways_of_eight_bits(const home::Home& home,
                                                       const std::vector<fs::path>& files) {
  ROOMWISE_TRY(std::vector<EightBitFile> ways, stored_ways_of_eight_bits(home));
  for (const fs::path& file : files) {
    if (!network::is_eight_bit_file(file)) continue;
    if (auto way = network::read_eight_bit_file(file)) ways.push_back(*std::move(way));
  }
  return ways;
}

// A network's weights file that is here.
struct FileHere {
  FileHere(fs::path file, std::string known_as)
      : path(std::move(file)), name(std::move(known_as)) {}

  fs::path path;
  std::string name;  // a detector is known by its file's

  // Empty where the file cannot be read. Read once: it may be large.
  [[nodiscard]] const std::string& sha256() {
    if (!sha256_) {
      const auto bytes = read_file(path);
      sha256_ = bytes ? sha256_hex(*bytes) : std::string();
    }
    return *sha256_;
  }
  // As it lies here with its card and labels, it is what the home knows by this.
  [[nodiscard]] bool is(const std::string& fingerprint) {
    if (sha256() == fingerprint) return true;
    const auto card = network::find_model_card(path);
    const auto labels = network::read_labels_of(path);
    return card && labels && network::network_fingerprint(sha256(), *card, *labels) == fingerprint;
  }

 private:
  std::optional<std::string> sha256_;
};

std::vector<FileHere> weights_here(const std::vector<fs::path>& files) {
  std::vector<FileHere> here;
  for (const fs::path& file : files) {
    std::error_code ignored;
    if (!network::has_ending_of_network(file) || !fs::exists(file, ignored)) continue;
    const auto card = network::find_model_card(file);
    const bool is_named = card && card->task == network::Task::kClassify;
    here.emplace_back(file, is_named ? card->name : file.stem().string());
  }
  return here;
}

// Of files with the same bytes one of the network's name goes first, so that others are mostly not
// read at all.
void compare(NeededNetwork& needed, std::vector<FileHere>& here) {
  if (const auto* entry = published(needed)) needed.published_as = entry->name;
  std::ranges::stable_partition(here,
                                [&](const FileHere& file) { return file.name == needed.name; });
  auto found = std::ranges::find_if(here, [&](FileHere& file) { return file.is(needed.sha256); });
  const bool is_right = found != here.end();
  if (!is_right) found = std::ranges::find(here, needed.name, &FileHere::name);
  if (found == here.end()) return;
  needed.file = found->path;
  needed.found_sha256 = found->sha256();
  const auto is_damaged = [&] {
    return is_said_of(found->path, needed) ||
           !network::read_network_file(found->path, std::nullopt);
  };
  needed.state = is_right       ? NetworkFileState::kRight
                 : is_damaged() ? NetworkFileState::kDamaged
                                : NetworkFileState::kOther;
}

}  // namespace

std::string_view name_of(NetworkFileState state) {
  switch (state) {
    case NetworkFileState::kRight:
      return "right";
    case NetworkFileState::kMissing:
      return "missing";
    case NetworkFileState::kDamaged:
      return "damaged";
    case NetworkFileState::kOther:
      break;
  }
  return "other";
}

Expected<std::vector<NeededNetwork>> check_network_files(const home::Home& home,
                                                         const std::vector<fs::path>& files) {
  ROOMWISE_TRY(std::vector<NeededNetwork> stored, stored_networks(home));
  if (stored.empty()) return stored;
  ROOMWISE_TRY(const std::vector<EightBitFile> ways, ways_of_eight_bits(home, files));
  std::vector<FileHere> here = weights_here(files);
  std::vector<NeededNetwork> needed;
  for (NeededNetwork& one : stored) {
    const auto way = std::ranges::find(ways, one.sha256, &EightBitFile::fingerprint);
    if (way != ways.end()) {
      one.sha256 = way->sha256;
      const auto same = std::ranges::find(here, one.name, [](const FileHere& file) {
        return network::name_in_eight_bits(file.name);
      });
      if (same != here.end()) one.name = same->name;
    }
    if (std::ranges::find(needed, one.sha256, &NeededNetwork::sha256) != needed.end()) continue;
    compare(one, here);
    needed.push_back(std::move(one));
  }
  return needed;
}

std::string in_words(const NeededNetwork& needed) {
  const std::string which = fmt::format("the network {}, {}", needed.name, needed.use);
  const std::string pull =
      needed.published_as.empty()
          ? ""
          : fmt::format(", or fetch it (roomwise networks pull {})", needed.published_as);
  constexpr std::size_t kShown = 12;  // digits; enough to tell two files apart
  switch (needed.state) {
    case NetworkFileState::kRight:
      return fmt::format("{}: is {}", needed.file.string(), which);
    case NetworkFileState::kMissing:
      return fmt::format("{}, is not here: put its file into a folder of networks{}", which, pull);
    case NetworkFileState::kDamaged:
      return fmt::format("{}: {}, is damaged: delete the file and put a copy of it there{}",
                         needed.file.string(), which, pull);
    case NetworkFileState::kOther:
      break;
  }
  return fmt::format(
      "{}: is not {} (now {}, then {}): put that file back{}, or have this one look at the home "
      "(roomwise objects find) and learn the rooms anew (roomwise rooms learn)",
      needed.file.string(), which, needed.found_sha256.substr(0, kShown),
      needed.sha256.substr(0, kShown), pull);
}

}  // namespace roomwise::pipeline
