#pragma once

#include <span>
#include <vector>

#include "roomwise/network/formats/model_card.h"

namespace roomwise::network {

// An upright rectangle of a picture, px: from `left` to before `right`.
struct PixelBox {
  float left = 0, top = 0, right = 0, bottom = 0;

  [[nodiscard]] float area() const;
  bool operator==(const PixelBox&) const = default;
};
// What both cover; of no area where they lie apart.
[[nodiscard]] PixelBox intersection(const PixelBox& a, const PixelBox& b);
// Of two boxes, the share of what they cover together that both cover.
[[nodiscard]] float intersection_over_union(const PixelBox& a, const PixelBox& b);

// A thing that was found in a picture.
struct Detection {
  std::size_t label = 0;  // index into Detector::labels()
  float score = 0;        // 0 to 1
  PixelBox box;           // in the picture's own pixels
};

// The detections in what a network gives whose card names a task of detection, for an input of the
// card's size: boxes in the input's pixels, best first. Of boxes of one label that overlap by more
// than 0.6 the best is kept; each box has its best label alone, where that scores more than
// `min_score`. Anchors are the cells of grids over the input, row by row, the finest grid first.
// Each gives, for n labels:
//   NanoDet-Plus (R. Lyu, 2021), strides 8, 16, 32, 64: n logits of scores, then for the distances
//     from the cell's corner to the box's left, top, right and bottom 8 logits each, of bins of one
//     stride.
//   YOLOX (Ge et al., 2021), strides 8, 16, 32: middle x, y from the cell's corner in strides,
//     logarithms of width and height in strides, the score of "a thing", n scores of labels.
//   YOLOv5 (Jocher, 2020), strides 8, 16, 32, three shapes a cell, one grid of cells a shape:
//     middle x, y, width, height in pixels, the score of "a thing", n scores of labels.
//   YOLOv8 (Jocher et al., 2023), strides 8, 16, 32: as YOLOv5 without the score of "a thing" and
//     with one shape a cell; all anchors' x come first, then all their y, and so on.
// output: of detector_output_size() values.
[[nodiscard]] std::vector<Detection> decode_detections(std::span<const float> output,
                                                       const ModelCard& card, std::size_t labels,
                                                       float min_score);
[[nodiscard]] std::size_t detector_output_size(const ModelCard& card, std::size_t labels);

}  // namespace roomwise::network
