#include "roomwise/objects/detection/activation_regions.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>
#include <utility>

namespace roomwise::objects {
namespace {

using network::CellLogits;

// Of each label the index of its word, or kNone.
constexpr std::size_t kNone = static_cast<std::size_t>(-1);
std::vector<std::size_t> word_indices(const std::vector<std::string>& labels,
                                      const ObjectVocabulary& words) {
  const auto& objects = words.objects();
  std::vector<std::size_t> indices;
  for (const std::string& label : labels) {
    const auto word = words.object_of(label);
    indices.push_back(
        word ? static_cast<std::size_t>(std::distance(objects.begin(), objects.find(*word)))
             : kNone);
  }
  return indices;
}

// How much each cell says one word.
class ActivationMap {
 public:
  ActivationMap(int columns, int rows)
      : columns_(columns), rows_(rows), values_(static_cast<std::size_t>(columns * rows), 0) {}

  void add(std::size_t cell, float value) { values_[cell] += value; }

  // Takes the best cell and those around it that share a side and are `min_cell` or more, as long
  // as the best is `min_peak` or more.
  [[nodiscard]] std::vector<std::vector<std::size_t>> take_regions(
      const ActivationOptions& options) {
    std::vector<std::vector<std::size_t>> regions;
    while (true) {
      const auto best = std::ranges::max_element(values_);
      if (*best < options.min_peak) return regions;
      regions.push_back(take_around(static_cast<std::size_t>(best - values_.begin()), options));
    }
  }

 private:
  std::vector<std::size_t> take_around(std::size_t first, const ActivationOptions& options) {
    std::vector<std::size_t> region{first}, open{first};
    values_[first] = 0;
    const auto take = [&](int column, int row) {
      if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return;
      const auto cell = static_cast<std::size_t>(row * columns_ + column);
      if (values_[cell] < options.min_cell) return;
      values_[cell] = 0;
      region.push_back(cell);
      open.push_back(cell);
    };
    const auto columns = static_cast<std::size_t>(columns_);
    while (!open.empty()) {
      const int column = static_cast<int>(open.back() % columns);
      const int row = static_cast<int>(open.back() / columns);
      open.pop_back();
      take(column - 1, row);
      take(column + 1, row);
      take(column, row - 1);
      take(column, row + 1);
    }
    return region;
  }

  int columns_, rows_;
  std::vector<float> values_;
};

// The probabilities of the labels over these cells, by the mean of their logits.
std::vector<float> said_of(const std::vector<std::size_t>& region, const CellLogits& cells) {
  std::vector<float> mean(cells.labels, 0);
  for (const std::size_t cell : region) {
    const auto logits = std::span(cells.values).subspan(cell * cells.labels, cells.labels);
    for (std::size_t label = 0; label < mean.size(); ++label)
      mean[label] += logits[label] / static_cast<float>(region.size());
  }
  return network::softmax(mean);
}

network::PixelBox box_about(const std::vector<std::size_t>& region, const CellLogits& cells,
                            int width_px, int height_px) {
  const float across = static_cast<float>(width_px) / static_cast<float>(cells.columns);
  const float down = static_cast<float>(height_px) / static_cast<float>(cells.rows);
  network::PixelBox box{static_cast<float>(width_px), static_cast<float>(height_px), 0, 0};
  for (const std::size_t cell : region) {
    const auto column = static_cast<float>(cell % static_cast<std::size_t>(cells.columns));
    const auto row = static_cast<float>(cell / static_cast<std::size_t>(cells.columns));
    box.left = std::min(box.left, column * across);
    box.top = std::min(box.top, row * down);
    box.right = std::max(box.right, (column + 1) * across);
    box.bottom = std::max(box.bottom, (row + 1) * down);
  }
  return box;
}

// Of labels whose words are known.
std::vector<network::Detection> find_regions(const CellLogits& cells,
                                             const std::vector<std::size_t>& word_of_label,
                                             std::size_t words, const ActivationOptions& options,
                                             int width_px, int height_px) {
  std::vector<ActivationMap> maps(words, ActivationMap(cells.columns, cells.rows));
  for (int row = 0; row < cells.rows; ++row) {
    for (int column = 0; column < cells.columns; ++column) {
      const std::vector<float> said = network::softmax(cells.at(column, row));
      const auto cell = static_cast<std::size_t>(row * cells.columns + column);
      for (std::size_t label = 0; label < said.size(); ++label) {
        if (word_of_label[label] != kNone) maps[word_of_label[label]].add(cell, said[label]);
      }
    }
  }
  std::vector<network::Detection> found;
  for (std::size_t word = 0; word < maps.size(); ++word) {
    for (const auto& region : maps[word].take_regions(options)) {
      const std::vector<float> said = said_of(region, cells);
      network::Detection detection;
      float most = -1;
      for (std::size_t label = 0; label < said.size(); ++label) {
        if (word_of_label[label] != word) continue;
        detection.score += said[label];
        if (said[label] <= most) continue;
        most = said[label];
        detection.label = label;
      }
      detection.box = box_about(region, cells, width_px, height_px);
      found.push_back(detection);
    }
  }
  std::ranges::stable_sort(found, std::greater{}, &network::Detection::score);
  return found;
}

class ActivationFinder final : public DetectionFinder {
 public:
  ActivationFinder(std::unique_ptr<network::DenseClassifier> classifier,
                   const ObjectVocabulary& words, const ActivationOptions& options)
      : classifier_(std::move(classifier)),
        word_of_label_(word_indices(classifier_->labels(), words)),
        words_(words.objects().size()),
        options_(options),
        name_("activation maps") {
    const network::ModelCard& card = classifier_->card();
    std::vector<std::string> names;
    for (const auto& [word, labels] : words.objects()) names.push_back(word);
    fingerprint_ =
        fmt::format("{}{}{}: {}x{}, {} and {}, {}", classifier_->fingerprint(), kActivationMethod,
                    kVersion, card.input_width_px, card.input_height_px, options.min_peak,
                    options.min_cell, fmt::join(names, ", "));
  }

  [[nodiscard]] const std::string& name() const override { return name_; }
  [[nodiscard]] const std::string& fingerprint() const override { return fingerprint_; }
  [[nodiscard]] const std::vector<std::string>& labels() const override {
    return classifier_->labels();
  }
  [[nodiscard]] Expected<std::vector<network::Detection>> find(
      const image::ColorImage& picture) const override {
    ROOMWISE_TRY(const CellLogits cells, classifier_->look(picture));
    return find_regions(cells, word_of_label_, words_, options_, picture.width(), picture.height());
  }

 private:
  // Counted up where the same options give other regions.
  static constexpr int kVersion = 1;

  std::unique_ptr<network::DenseClassifier> classifier_;
  std::vector<std::size_t> word_of_label_;
  std::size_t words_;
  ActivationOptions options_;
  std::string name_, fingerprint_;
};

}  // namespace

std::vector<network::Detection> activation_regions(const CellLogits& cells,
                                                   const std::vector<std::string>& labels,
                                                   const ObjectVocabulary& words,
                                                   const ActivationOptions& options, int width_px,
                                                   int height_px) {
  return find_regions(cells, word_indices(labels, words), words.objects().size(), options, width_px,
                      height_px);
}

ObjectVocabulary classes_of_maps(const DetectionFinders& finders,
                                 const std::vector<std::string>& labels,
                                 const ObjectVocabulary& vocabulary) {
  static const std::set<std::string> kFoundRightly{"bookcase"};
  return classes_with_labels(vocabulary, labels, [&](const std::string& word) {
    const bool is_found = std::ranges::any_of(finders, [&](const auto& finder) {
      return std::ranges::any_of(finder->labels(), [&](const std::string& label) {
        return vocabulary.object_of(label) == word;
      });
    });
    return finders.empty() || (!is_found && kFoundRightly.contains(word));
  });
}

std::unique_ptr<DetectionFinder> activation_finder(
    std::unique_ptr<network::DenseClassifier> classifier, const ObjectVocabulary& words,
    const ActivationOptions& options) {
  return std::make_unique<ActivationFinder>(std::move(classifier), words, options);
}

}  // namespace roomwise::objects
