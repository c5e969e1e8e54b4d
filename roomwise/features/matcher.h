#pragma once

#include <cstdint>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/base/simd.h"
#include "roomwise/features/feature_extractor.h"

namespace roomwise::features {

struct MatchOptions {
  // A match's distance must be below this part of the distance to the second nearest (Lowe 2004).
  // Above 0 and at most 1; 1 switches the test off.
  double max_distance_ratio = 0.8;
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
// order of query. Exact: compares all pairs of equal polarity (Keypoint::bright),
// O(|query| |train|); of equally near neighbours the first counts as the nearest.
//
// The ratio test can only be passed where there is a second nearest: a feature with a single
// candidate has no match (unless the test is off), nor has one whose two nearest are equally near.
// No features on either side give no matches. Descriptors of two kinds or lengths, or options that
// are not valid, are a programming error (std::invalid_argument). Real descriptors are compared in
// whole numbers (QuantizedDescriptors): the same bits whatever instructions the processor has.
[[nodiscard]] std::vector<Match> match_features(const Features& query, const Features& train,
                                                const MatchOptions& options = {},
                                                Simd simd = process_simd());

}  // namespace roomwise::features
