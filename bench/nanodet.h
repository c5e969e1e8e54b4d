#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/image/image.h"
#include "roomwise/network/executor.h"

namespace roomwise::bench {

// An upright rectangle of a picture, px: from `left` to before `right`.
struct PixelBox {
  float left = 0, top = 0, right = 0, bottom = 0;

  [[nodiscard]] float area() const;
};
// Of two boxes, the share of what they cover together that both cover.
[[nodiscard]] float intersection_over_union(const PixelBox& a, const PixelBox& b);

struct Detection {
  std::size_t label = 0;  // index into NanoDet::labels()
  float score = 0;
  PixelBox box;
};

// What NanoDet-Plus gives for a picture of kNanoDetSide x kNanoDetSide, one row an anchor: the
// logit of each label's score, then for the distances to the box's left, top, right and bottom the
// logits of 8 bins, in strides. Of boxes of one label that overlap the best is kept.
constexpr int kNanoDetSide = 416;
[[nodiscard]] std::size_t nanodet_anchors();
[[nodiscard]] std::vector<Detection> decode_nanodet(std::span<const float> rows, std::size_t labels,
                                                    float least_score);

// The detector NanoDet-Plus-m of 416x416 (R. Lyu, 2021), trained on COCO. detect() may be called
// from several threads at once.
class NanoDet {
 public:
  // The weights as ONNX, and a text file with one label a line.
  [[nodiscard]] static Expected<std::unique_ptr<NanoDet>> load(const std::filesystem::path& weights,
                                                               const std::filesystem::path& labels);

  [[nodiscard]] const std::vector<std::string>& labels() const { return labels_; }
  // What scores more than `least_score`, best first.
  [[nodiscard]] Expected<std::vector<Detection>> detect(const image::ColorImage& image,
                                                        float least_score) const;

 private:
  NanoDet(std::vector<std::string> labels, std::unique_ptr<network::Executor> executor);

  std::vector<std::string> labels_;
  std::unique_ptr<network::Executor> executor_;
};

}  // namespace roomwise::bench
