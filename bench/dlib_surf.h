#pragma once

#include "roomwise/features/feature_extractor.h"

namespace roomwise::bench {

// dlib's SURF behind our interface, to be measured beside ours.
class DlibSurfExtractor final : public features::FeatureExtractor {
 public:
  explicit DlibSurfExtractor(int most_keypoints) : most_keypoints_(most_keypoints) {}
  [[nodiscard]] features::Features extract(const image::GrayImage& image) const override;

 private:
  int most_keypoints_;
};

}  // namespace roomwise::bench
