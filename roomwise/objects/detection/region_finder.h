#pragma once

#include <memory>
#include <string>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/image/image.h"
#include "roomwise/network/vision/detector.h"
#include "roomwise/objects/detection/detection.h"

namespace roomwise::objects {

// Something that finds where in a picture things are. find() may be called from several threads at
// once.
class DetectionFinder {
 public:
  virtual ~DetectionFinder() = default;

  [[nodiscard]] virtual const std::string& name() const = 0;
  // Tells finders apart whose findings may differ: SHA-256 of the weights file, and the method
  // where one network serves several.
  [[nodiscard]] virtual const std::string& fingerprint() const = 0;
  [[nodiscard]] virtual const std::vector<std::string>& labels() const = 0;
  // Best first; boxes in the picture's own pixels.
  [[nodiscard]] virtual Expected<std::vector<network::Detection>> find(
      const image::ColorImage& picture) const = 0;
};

using DetectionFinders = std::vector<std::unique_ptr<DetectionFinder>>;

// The boxes of a detector that score more than `min_score`. What is stored cannot be had back, so
// the score is lower than what counts later.
[[nodiscard]] std::unique_ptr<DetectionFinder> detector_finder(
    std::string name, std::shared_ptr<const network::Detector> detector, float min_score = 0.2F);

}  // namespace roomwise::objects
