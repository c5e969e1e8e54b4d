#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/image/image.h"
#include "roomwise/network/executor/executor.h"
#include "roomwise/network/formats/model_card.h"
#include "roomwise/network/vision/detection.h"

namespace roomwise::network {

// A network that finds things in pictures, read from an ONNX file whose card names such a task
// (decode_detections() says which there are). detect() may be called from several threads at once.
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

}  // namespace roomwise::network
