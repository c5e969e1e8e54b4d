#pragma once

#include <memory>
#include <string>
#include <vector>

#include "roomwise/network/vision/dense_classifier.h"
#include "roomwise/objects/detection/object_vocabulary.h"
#include "roomwise/objects/detection/region_finder.h"

namespace roomwise::objects {

// How regions are cut out of a classifier's class-activation maps; probabilities, 0 < min_cell <=
// min_peak.
struct ActivationOptions {
  float min_peak = 0.4F;  // of a region's best cell
  float min_cell = 0.2F;  // of the cells around it
};

// The regions of a picture of which cells say the same: for each of the words (by the sum of its
// labels' probabilities) the cells of `min_cell` or more that share a side, around a best one of
// `min_peak` or more. A region's label is the one of its word that its cells say most, its score
// what the classifier says of its cells together. Boxes are in pixels of a picture of this size.
// Best first.
[[nodiscard]] std::vector<network::Detection> activation_regions(
    const network::CellLogits& cells, const std::vector<std::string>& labels,
    const ObjectVocabulary& words, const ActivationOptions& options, int width_px, int height_px);

// What class-activation maps are asked for: beside other finders, of the words that none of them
// has a label for and the labels do, those that maps find rightly
// (docs/experiments/objects-activation-maps-which-classes.md); alone, all that the labels have; and
// look-alikes that the labels have.
[[nodiscard]] ObjectVocabulary classes_of_maps(const DetectionFinders& finders,
                                               const std::vector<std::string>& labels,
                                               const ObjectVocabulary& vocabulary);

// Finds these words by a classifier's class-activation maps.
[[nodiscard]] std::unique_ptr<DetectionFinder> activation_finder(
    std::unique_ptr<network::DenseClassifier> classifier, const ObjectVocabulary& words,
    const ActivationOptions& options = {});

}  // namespace roomwise::objects
