#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace roomwise::mapping {

// A feature of a key-frame.
struct FeatureId {
  std::uint32_t keyframe = 0;
  std::uint32_t index = 0;

  friend auto operator<=>(const FeatureId&, const FeatureId&) = default;
};

struct FeatureMatch {
  FeatureId a;
  FeatureId b;
  float distance = 0;  // between their descriptors
};

// Features of several key-frames that belong together, by key-frame.
using FeatureTrack = std::vector<FeatureId>;

// Joins matched features to tracks, the most alike first; a match that would put two features of
// one key-frame into a track is passed over. `sizes` says how many features each key-frame has. The
// tracks come in the order of their first features.
[[nodiscard]] std::vector<FeatureTrack> join_tracks(std::span<const std::size_t> sizes,
                                                    std::vector<FeatureMatch> matches);

}  // namespace roomwise::mapping
