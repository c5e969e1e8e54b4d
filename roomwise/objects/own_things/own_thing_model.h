#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "roomwise/base/expected.h"

namespace roomwise::objects {

// What speaks for a place in a picture being a thing that was taught.
//   embedding: cosine similarity of the network's features, without what all of the home's places
//     have in common, to the view that is most alike;
//   embedding_mean: the same in the mean over the three that are;
//   inliers: log(1 + n), n local features that agree where the view lies;
//   color: likeness of the colours.
constexpr std::size_t kMatchFeatures = 4;
using MatchFeatures = std::array<double, kMatchFeatures>;
constexpr std::array<std::string_view, kMatchFeatures> kMatchFeatureNames{
    "embedding", "embedding_mean", "inliers", "color"};

// A logistic regression on likeness: own_thing_model.json, which roomwise-lab own-things writes and
// where it stands what it was fitted on.
struct OwnThingModel {
  double bias = 0;
  MatchFeatures weights{};
  // Log odds above the usual ones of a home's pictures, from which on a thing counts as found: such
  // that in an hour of walking, a picture a second, one that is not there is found once in the
  // mean.
  double margin = 0;

  [[nodiscard]] double log_odds(const MatchFeatures& likeness) const;
  // Fails, naming the field, where one is missing, of another type or not finite, or is none that
  // this program knows.
  [[nodiscard]] static Expected<OwnThingModel> parse(std::string_view json);
  [[nodiscard]] static const OwnThingModel& built_in();
};

// From which log odds on a thing counts as found in a home. `scores`: the best of each of the
// home's pictures; their median is what is usual there, so that up to half of them may show the
// thing. Fails where there are fewer than kMinCalibrationPictures.
constexpr std::size_t kMinCalibrationPictures = 20;
[[nodiscard]] Expected<double> found_threshold(std::vector<double> scores,
                                               const OwnThingModel& model);

}  // namespace roomwise::objects
