#pragma once

#include <string>
#include <vector>

#include "roomwise/pipeline/objects/keyframe_observer.h"

namespace roomwise::pipeline {

// A network, or a finder of regions, that has the name of one that looked at this home and whose
// weights are not the same.
struct ChangedNetwork {
  std::string name;
  std::string stored;  // fingerprints: of the one that looked at the home last,
  std::string here;    // and of the one that was loaded

  friend bool operator==(const ChangedNetwork&, const ChangedNetwork&) = default;
};

// Compares what was loaded with what the home stores of the networks and finders that it was made
// with. What the home holds of the stored one means nothing to the other: rooms are not asked by it
// (RoomRecognizer), and key-frames are looked at anew when it next maps or finds objects.
[[nodiscard]] Expected<std::vector<ChangedNetwork>> changed_networks(
    const home::Home& home, const Networks& networks, const objects::DetectionFinders& finders);

// One line for people: what is wrong, and the two ways to mend it.
[[nodiscard]] std::string in_words(const ChangedNetwork& changed, const std::string& home);

}  // namespace roomwise::pipeline
