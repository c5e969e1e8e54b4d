#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "roomwise/network/vision/classifier.h"
#include "roomwise/network/vision/detector.h"
#include "roomwise/objects/detection/object_vocabulary.h"
#include "roomwise/objects/detection/region_finder.h"

namespace roomwise::objects {

// How boxes are chosen, cut out and believed.
struct CropOptions {
  float min_box_score = 0.1F;   // of a detector's box, whatever it calls it
  float min_word_score = 0.5F;  // that a classifier gives to the word, by the sum of its labels
  float margin = 1.15F;         // sides of what is cut out, in longest sides of the box
  float nms_iou = 0.7F;         // boxes that overlap by more are one, the best
};

// Pictures have pixels. The square about the middle of a box whose sides are `margin` of the box's
// longest, moved and cut to lie in the picture: as much of it as a classifier needs to see what the
// box holds. Whole pixels.
[[nodiscard]] network::PixelBox square_about(const network::PixelBox& box, float margin,
                                             int width_px, int height_px);

// What crops are asked for: the words that they find rightly
// (docs/experiments/objects-crops-which-classes.md) and the labels have, and look-alikes that the
// labels have.
[[nodiscard]] ObjectVocabulary classes_of_crops(const std::vector<std::string>& labels,
                                                const ObjectVocabulary& vocabulary);

// The boxes of a detector, best first, as a classifier calls what is cut out of the picture about
// each: the one of these words that it says most, if it says it enough, by the sum of the word's
// labels; the label is the likeliest of them. A crop that shows half or more of a better box of its
// word says what stands beside: it is left out. Best first. Fails where the classifier does.
[[nodiscard]] Expected<std::vector<network::Detection>> crop_regions(
    const image::ColorImage& picture, std::span<const network::Detection> boxes,
    const network::Classifier& classifier, const ObjectVocabulary& words,
    const CropOptions& options);

// Finds these words by the crops of a detector's boxes (regions with features of a network: R.
// Girshick et al., "Rich feature hierarchies for accurate object detection and semantic
// segmentation", 2014). A detector finds lampshades and baths, too, and calls them vases and sinks,
// since it knows no other word; seen alone, a classifier tells them.
[[nodiscard]] std::unique_ptr<DetectionFinder> crop_finder(
    std::shared_ptr<const network::Detector> detector,
    std::shared_ptr<const network::Classifier> classifier, const ObjectVocabulary& words,
    const CropOptions& options = {});

}  // namespace roomwise::objects
