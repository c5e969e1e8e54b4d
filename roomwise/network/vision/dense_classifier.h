#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/image/image.h"
#include "roomwise/network/executor/executor.h"
#include "roomwise/network/formats/model_card.h"
#include "roomwise/network/vision/detector.h"

namespace roomwise::network {

// A classifier's network without its pooling. Where a classifier ends in the mean of a feature map
// over the whole picture and linear layers behind it, these layers are put on each cell of the map
// instead: the graph's only output gives their logits, 1 x labels x rows x columns, without the
// softmax at the end. The mean of the cells' logits are the whole picture's (up to rounding), since
// a mean of linear values is the linear value of the mean (class activation maps: B. Zhou et al.,
// "Learning deep features for discriminative localization", 2016). Height and width of the input
// become free.
//
// `scores`: the value or the node that gives the classifier's scores. Fails, naming the node, where
// they are not made that way.
[[nodiscard]] Expected<OnnxGraph> dense_graph(const OnnxGraph& graph, const std::string& scores);

// The probabilities that logits (at least one) mean.
[[nodiscard]] std::vector<float> softmax(std::span<const float> logits);

// What a network says of each cell of a picture. The mean of some cells' logits is what it would
// say if it pooled over this part of the picture alone.
struct CellLogits {
  int columns = 0, rows = 0;
  std::size_t labels = 0;
  std::vector<float> values;  // rows x columns x labels

  [[nodiscard]] std::span<const float> at(int column, int row) const;
};

// A classifier that is asked about every part of a picture at once (dense_graph()). look() may be
// called from several threads at once.
class DenseClassifier {
 public:
  // The size that pictures are stretched to, px. Larger makes more cells, each of a smaller part of
  // the picture: finer, until things are larger than the network has learned them.
  struct InputSize {
    int width_px = 0, height_px = 0;
  };
  // 352x256 for a network that takes 224x224 or less, and as much larger for others, in steps of 32
  // pixels, by which such networks make a picture smaller.
  [[nodiscard]] static InputSize usual_size(const ModelCard& card);
  // size: absent: usual_size(). labels: a text file, one label a line; absent: the one that the
  // card names. Fails as
  // OnnxClassifier::load() does, where the network names nothing, and where it has no layers as
  // dense_graph() asks for, or gives another number of scores than there are labels.
  [[nodiscard]] static Expected<std::unique_ptr<DenseClassifier>> load(
      const std::filesystem::path& weights, std::optional<InputSize> size = std::nullopt,
      const std::optional<std::filesystem::path>& labels = std::nullopt);

  [[nodiscard]] const ModelCard& card() const { return card_; }  // its input is of `size`
  [[nodiscard]] const std::vector<std::string>& labels() const { return labels_; }
  // SHA-256 of the weights file.
  [[nodiscard]] const std::string& fingerprint() const { return fingerprint_; }

  [[nodiscard]] Expected<CellLogits> look(const image::ColorImage& image) const;

 private:
  DenseClassifier() = default;

  ModelCard card_;
  std::vector<std::string> labels_;
  std::string fingerprint_;
  std::unique_ptr<Executor> executor_;
};

}  // namespace roomwise::network
