#pragma once

#include <string>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/image/image.h"

namespace roomwise::network {

// What a network sees in one picture.
struct Prediction {
  std::vector<float> features;  // what the picture looks like; of the network's feature_size()
  std::vector<float>
      scores;  // probability of each label, in the order of labels(); empty without labels
};

// A convolutional network that looks at whole pictures. predict() may be called from several
// threads at once and gives the same bits on every call, whatever the number of threads.
class Classifier {
 public:
  virtual ~Classifier() = default;
  // For people: "mobilenet-v2-imagenet".
  [[nodiscard]] virtual const std::string& name() const = 0;
  // SHA-256 of the weights file: what was learned on the features of one network means nothing to
  // another.
  [[nodiscard]] virtual const std::string& fingerprint() const = 0;
  // What is done to a picture before the weights see it, and which of their outputs are taken: a
  // text that tells two ways of it apart, for what was computed with one way and kept. Empty where
  // there is only one.
  [[nodiscard]] virtual std::string preprocessing() const { return {}; }
  // What it can name; empty for a network that serves features only.
  [[nodiscard]] virtual const std::vector<std::string>& labels() const = 0;
  [[nodiscard]] virtual std::size_t feature_size() const = 0;
  [[nodiscard]] virtual Expected<Prediction> predict(const image::ColorImage& image) const = 0;
};

}  // namespace roomwise::network
