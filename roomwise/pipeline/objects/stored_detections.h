#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "roomwise/home/home.h"
#include "roomwise/objects/instances/instances.h"

namespace roomwise::pipeline {

// What networks said of each key-frame as a whole, in the home's words: of those that name things
// the newest that has looked at it. Scores below `min_score` are left out.
[[nodiscard]] Expected<std::map<home::KeyframeId, std::vector<objects::Observation>>>
said_of_pictures(const home::Home& home, const objects::ObjectVocabulary& vocabulary,
                 double min_score);

// The regions that the home has a word for, and those of look-alikes. What they point to is the
// look's.
[[nodiscard]] std::vector<objects::NamedRegion> named_regions(
    const objects::KeyframeDetections& look, const objects::ObjectVocabulary& vocabulary);

// The looks that are stored in a home, as the rules of objects/ take them.
class StoredDetections {
 public:
  [[nodiscard]] static Expected<StoredDetections> read(const home::Home& home);
  StoredDetections(StoredDetections&&) = default;
  StoredDetections& operator=(StoredDetections&&) = delete;

  // The key-frames that were looked at, by id, of each component of the map. They live as long as
  // this.
  [[nodiscard]] const std::map<std::uint64_t, std::vector<objects::ObservedKeyframe>>& components()
      const {
    return components_;
  }

 private:
  StoredDetections() = default;

  std::map<home::RecordingId, geometry::PinholeCamera> cameras_;
  std::map<home::KeyframeId, objects::KeyframeDetections> looks_;
  std::map<std::uint64_t, std::vector<objects::ObservedKeyframe>> components_;
};

}  // namespace roomwise::pipeline
