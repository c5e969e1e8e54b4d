#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "roomwise/network/formats/model_card.h"
#include "roomwise/network/vision/classifier.h"

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
  ~OnnxClassifier() override;

  [[nodiscard]] const std::string& name() const override;
  [[nodiscard]] const std::string& fingerprint() const override;
  [[nodiscard]] std::string preprocessing() const override;
  [[nodiscard]] const std::vector<std::string>& labels() const override;
  [[nodiscard]] std::size_t feature_size() const override;
  [[nodiscard]] Expected<Prediction> predict(const image::ColorImage& image) const override;

  [[nodiscard]] const ModelCard& card() const;

 private:
  class Implementation;
  explicit OnnxClassifier(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> implementation_;
};

// Where networks are looked for unless the user says otherwise: ROOMWISE_MODELS if it is set, else
// ../shared/models from the current folder if that is a folder, else nowhere.
[[nodiscard]] std::optional<std::filesystem::path> default_model_folder();

}  // namespace roomwise::network
