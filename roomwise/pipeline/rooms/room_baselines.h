#pragma once

#include <span>
#include <vector>

#include "roomwise/pipeline/rooms/room_evaluation.h"

namespace roomwise::pipeline {

struct BaselineOptions {
  // The vote of features compares a picture with every key-frame, which takes long: so many
  // pictures at most, spread evenly, with so many key-frames of each room at most. 0: no vote.
  std::size_t max_voted_pictures = 60;
  std::size_t max_voted_keyframes = 12;
};

// Simple ways of recognising rooms, for comparison, each from one picture against the key-frames
// that the home's rooms were learned from:
//
//  - the most alike colours: histograms of hue, saturation and value (16 x 4 x 4 cells) compared by
//    their intersection (Swain and Ballard 1991);
//  - the nearest key-frame by the cosine of the network's features;
//  - a vote of matched SIFT features: the inliers of a pose found by RANSAC against each key-frame
//    and its depth, added up by room; a picture without any inlier is not named.
//
// `features`: what recognizer.features() saw in each picture. Fails where the home does not know
// which key-frames its rooms were learned from.
[[nodiscard]] Expected<std::vector<RuleResult>> baseline_rules(
    const home::Home& home, const std::vector<LabelledPicture>& pictures,
    std::span<const std::vector<float>> features, const RoomRecognizer& recognizer,
    const BaselineOptions& options, RunContext& run);

// The histogram of a picture's colours, which adds up to 1.
[[nodiscard]] std::vector<float> color_histogram(const image::ColorImage& picture);

}  // namespace roomwise::pipeline
