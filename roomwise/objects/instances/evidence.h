#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "roomwise/objects/instances/world_observation.h"

namespace roomwise::objects {

// What speaks for and against a candidate: what the model of instances (instance_model.h) is told.
// Shares lie in [0, 1]; logarithms are natural.
constexpr std::array<std::string_view, 8> kEvidenceNames = {
    "sum of scores",  // log(1 + that of all observations)
    "seen share",     // of the key-frames that show its place, those that show it there
    "rival",          // log of its scores' sum over that of the strongest of another class
    "twin",           // of a candidate of its class near by with a larger sum of scores: log of the
                      // ratio of the sums; 0 where there is none, the same below
    "twin near",      // 1 where it is in the same place, falling to 0 at 1.5 usual lengths
    "with the twin",  // share of its key-frames that have that one, too
    "larger",         // log of its extent over the usual one, where larger
    "on the floor",   // 1 where its foot is on a floor and such things stand on others
};
using Evidence = std::array<double, kEvidenceNames.size()>;

// The key-frames that show a candidate, and those that should and have nothing there. Of what only
// region proposals show none should: they are shown a few views alone.
struct Visibility {
  int observed = 0, missed = 0;
};
[[nodiscard]] Visibility visibility_of(const Candidate& candidate,
                                       std::span<const WorldObservation> observations,
                                       std::span<const ObservedKeyframe> keyframes,
                                       double max_range_m);

// Of each candidate, among the others; `visibility` is theirs.
[[nodiscard]] std::vector<Evidence> evidence_of(std::span<const Candidate> candidates,
                                                std::span<const Visibility> visibility,
                                                std::span<const WorldObservation> observations,
                                                const GroundPlane& level);

}  // namespace roomwise::objects
