#include "roomwise/pipeline/objects/changed_networks.h"

#include <algorithm>
#include <map>

namespace roomwise::pipeline {
namespace {

// The fingerprints under which a home knows a name; the last is the newest.
using Known = std::map<std::string, std::vector<std::string>>;

template <typename Records>
Known known_by_name(const Records& records) {
  Known known;
  for (const auto& [id, record] : records) known[record.name].push_back(record.fingerprint);
  return known;
}

void compare(const Known& known, const std::string& name, const std::string& here,
             std::vector<ChangedNetwork>& changed) {
  const auto found = known.find(name);
  if (found == known.end() || std::ranges::find(found->second, here) != found->second.end()) return;
  changed.push_back({name, found->second.back(), here});
}

}  // namespace

Expected<std::vector<ChangedNetwork>> changed_networks(const home::Home& home,
                                                       const Networks& networks,
                                                       const objects::DetectionFinders& finders) {
  ROOMWISE_TRY(const auto stored, home.networks());
  ROOMWISE_TRY(const auto stored_finders, home.region_finders());
  ROOMWISE_TRY(const auto rooms, home.room_classifier());
  Known known = known_by_name(stored);
  // Rooms may have been learned of photos alone, at which no key-frame's network looked.
  if (rooms) known[rooms->network_name].push_back(rooms->network_fingerprint);
  std::vector<ChangedNetwork> changed;
  for (const auto& network : networks) {
    compare(known, network->name(), network->fingerprint(), changed);
  }
  const Known known_finders = known_by_name(stored_finders);
  for (const auto& finder : finders) {
    compare(known_finders, finder->name(), finder->fingerprint(), changed);
  }
  return changed;
}

std::string in_words(const ChangedNetwork& changed, const std::string& home) {
  constexpr std::size_t kShown = 12;  // digits; enough to tell two files apart
  return fmt::format(
      "{}: the network {} is not the one that this home was made with (now {}, then {}): what was "
      "learned with that one is not asked; put its file back, or have this one look at the home "
      "(roomwise objects find) and learn the rooms anew (roomwise rooms learn)",
      home, changed.name, changed.here.substr(0, kShown), changed.stored.substr(0, kShown));
}

}  // namespace roomwise::pipeline
