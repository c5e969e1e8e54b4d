#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "roomwise/home/home.h"
#include "roomwise/objects/instances/instances.h"

namespace roomwise::pipeline {

// What networks said of each key-frame as a whole, in the home's words: of those that name things
// the newest that has looked at it. Scores below `min_score` are left out.
[[nodiscard]] Expected<std::map<home::KeyframeId, std::vector<objects::ObjectScore>>>
said_of_pictures(const home::Home& home, const objects::ObjectVocabulary& vocabulary,
                 double min_score);

// The key-frames of a home that finders looked at, by id, of each component of the map, as the
// rules of objects/ take them.
[[nodiscard]] Expected<std::map<std::uint64_t, std::vector<objects::ObservedKeyframe>>>
observed_keyframes(const home::Home& home);

}  // namespace roomwise::pipeline
