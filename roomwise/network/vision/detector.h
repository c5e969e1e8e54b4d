#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/image/image.h"
#include "roomwise/network/executor/executor.h"
#include "roomwise/network/formats/model_card.h"

namespace roomwise::network {

// An upright rectangle of a picture, px: from `left` to before `right`.
struct PixelBox {
  float left = 0, top = 0, right = 0, bottom = 0;

  [[nodiscard]] float area() const;
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

// NanoDet-Plus (R. Lyu, 2021), read from an ONNX file whose card says "task": "nanodet-plus". It
// gives one row an anchor, the anchors row by row at strides of 8, 16, 32 and 64 pixels: the logit
// of each label's score, then for the distances to the box's left, top, right and bottom the logits
// of 8 bins, in strides. detect() may be called from several threads at once.
class Detector {
 public:
  // labels: a text file, one label a line; absent: the one that the card names. Fails as
  // OnnxClassifier::load() does, and where the network gives other rows than its labels ask for.
  [[nodiscard]] static Expected<std::unique_ptr<Detector>> load(
      const std::filesystem::path& weights,
      const std::optional<std::filesystem::path>& labels = std::nullopt);

  [[nodiscard]] const ModelCard& card() const { return card_; }
  [[nodiscard]] const std::vector<std::string>& labels() const { return labels_; }
  // SHA-256 of the weights file.
  [[nodiscard]] const std::string& fingerprint() const { return fingerprint_; }

  // What scores more than `min_score`, best first. Of boxes of one label that overlap by more
  // than 0.6 the best is kept.
  [[nodiscard]] Expected<std::vector<Detection>> detect(const image::ColorImage& image,
                                                        float min_score) const;

 private:
  Detector() = default;

  ModelCard card_;
  std::vector<std::string> labels_;
  std::string fingerprint_;
  std::unique_ptr<Executor> executor_;
};

// The detections in what NanoDet-Plus gives for an input of the card's size, boxes in the input's
// pixels. rows: as many as the card's size has anchors (nanodet_anchors()), each of `labels` + 32
// values.
[[nodiscard]] std::vector<Detection> decode_nanodet(std::span<const float> rows,
                                                    const ModelCard& card, std::size_t labels,
                                                    float min_score);
[[nodiscard]] std::size_t nanodet_anchors(const ModelCard& card);

}  // namespace roomwise::network
