#pragma once

#include <memory>
#include <string>
#include <vector>

#include "roomwise/features/feature_extractor.h"

namespace roomwise::bench {

struct FeatureMethod {
  std::string name;
  std::unique_ptr<features::FeatureExtractor> extractor;
};

// Our SURF with the best instructions there are and without any, dlib's (where it was built with
// it), and OpenCV's SIFT and ORB, each with thresholds so low that nearly every picture of a room
// fills `max_keypoints`.
[[nodiscard]] std::vector<FeatureMethod> feature_methods(int max_keypoints);

}  // namespace roomwise::bench
