#pragma once

#include "roomwise/features/feature_extractor.h"

namespace roomwise::bench {

// dlib's SURF behind our interface, to be measured beside ours.
class DlibSurfExtractor final : public features::FeatureExtractor {
 public:
  explicit DlibSurfExtractor(int max_keypoints) : max_keypoints_(max_keypoints) {}
  [[nodiscard]] features::Features extract(const image::GrayImage& image) const override;

 private:
  int max_keypoints_;
};

}  // namespace roomwise::bench
