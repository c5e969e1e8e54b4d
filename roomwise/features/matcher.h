#pragma once

#include <cstdint>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/features/feature_extractor.h"

namespace roomwise::features {

struct MatchOptions {
  // A match's distance must be below this part of the distance to the second nearest (Lowe 2004).
  double most_distance_ratio = 0.8;
  // Each of the two must be the other's nearest.
  bool mutual = true;

  [[nodiscard]] Expected<void> validate() const;
};

struct Match {
  std::uint32_t query = 0;  // index into the query's key-points
  std::uint32_t train = 0;  // index into the train's key-points
  float distance = 0;       // Euclidean, or Hamming in bits
};

// Nearest neighbours of query among train that pass the ratio test and the mutual check, in the
// order of query. Both must be of one kind. Exact: compares all pairs, O(|query| |train|).
[[nodiscard]] std::vector<Match> match_features(const Features& query, const Features& train,
                                                const MatchOptions& options = {});

}  // namespace roomwise::features
