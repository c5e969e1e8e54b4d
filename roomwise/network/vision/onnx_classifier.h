#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "roomwise/network/executor/executor.h"
#include "roomwise/network/vision/classifier.h"
#include "roomwise/network/vision/classifier_outputs.h"

namespace roomwise::network {

// A convolutional network read from an ONNX file, from a file of weights for a network of our own
// (network_file.h), or as a file of 8 bits says (eight_bit_file.h), and run by our executor
// (executor.h) on the calling thread. What the file does not say stands in its model card
// (model_card.h).
//
// Threads that predict at the same time share the weights; each has memory of its own for what
// comes between the layers (1 to 10 MB), made when needed and kept.
class OnnxClassifier final : public Classifier {
 public:
  // labels: a text file, one label a line in the order of the network's scores; absent: the one
  // that the card names (which must be there), if any. Fails where the file is missing, is no ONNX
  // network or one with operators that are not supported, does not take colour pictures of the
  // card's size, gives no output of the card's names, or has another number of scores than there
  // are labels.
  [[nodiscard]] static Expected<std::unique_ptr<OnnxClassifier>> load(
      const std::filesystem::path& weights,
      const std::optional<std::filesystem::path>& labels = std::nullopt);
  // The same of what was read already; errors name `weights`.
  [[nodiscard]] static Expected<std::unique_ptr<OnnxClassifier>> create(
      NetworkFile file, const std::filesystem::path& weights);

  [[nodiscard]] const std::string& name() const override { return card_.name; }
  [[nodiscard]] const std::string& fingerprint() const override { return fingerprint_; }
  [[nodiscard]] std::string preprocessing() const override {
    return preprocessing_of(card_, outputs_);
  }
  [[nodiscard]] const std::vector<std::string>& labels() const override { return labels_; }
  [[nodiscard]] std::size_t feature_size() const override { return feature_size_; }
  [[nodiscard]] Expected<Prediction> predict(const image::ColorImage& image) const override;

  [[nodiscard]] const ModelCard& card() const { return card_; }

 private:
  OnnxClassifier() = default;
  [[nodiscard]] Expected<void> probe();

  ModelCard card_;
  std::vector<std::string> labels_;
  std::string fingerprint_;
  ClassifierOutputs outputs_;
  std::unique_ptr<Executor> executor_;
  std::size_t feature_size_ = 0;
};

// Where networks are looked for unless the user says otherwise: ROOMWISE_MODELS if it is set, else
// ../shared/models from the current folder if that is a folder, else nowhere.
[[nodiscard]] std::optional<std::filesystem::path> default_model_folder();

}  // namespace roomwise::network
