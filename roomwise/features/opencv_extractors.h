#pragma once

#include "roomwise/features/feature_extractor.h"

namespace roomwise::features {

// SIFT (Lowe 2004) by OpenCV, 128 values of unit length, as RootSIFT (Arandjelovic and Zisserman,
// "Three things everyone should know to improve object retrieval", CVPR 2012), which gives slightly
// more correct matches than the plain values. size_px is the side of the descriptor's window.
class SiftExtractor final : public FeatureExtractor {
 public:
  // At most so many key-points a picture, the strongest; 0 keeps all. A negative number is a
  // programming error (std::invalid_argument). contrast_threshold is OpenCV's.
  explicit SiftExtractor(int max_keypoints, double contrast_threshold = 0.04);
  [[nodiscard]] Features extract(const image::GrayImage& image) const override;

 private:
  int max_keypoints_;
  double contrast_threshold_;
};

// ORB (Rublee et al. 2011) by OpenCV, 32 bytes. size_px is the side of the described patch.
class OrbExtractor final : public FeatureExtractor {
 public:
  // At most so many key-points a picture, shared out over the scales and then by strength; at least
  // 1 (ORB has no way to keep all). Less is a programming error (std::invalid_argument).
  // corner_threshold is OpenCV's for FAST, in grey levels.
  explicit OrbExtractor(int max_keypoints, int corner_threshold = 20);
  [[nodiscard]] Features extract(const image::GrayImage& image) const override;

 private:
  int max_keypoints_;
  int corner_threshold_;
};

}  // namespace roomwise::features
