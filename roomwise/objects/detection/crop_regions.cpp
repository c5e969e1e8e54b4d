#include "roomwise/objects/detection/crop_regions.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <utility>

#include "roomwise/image/resample.h"

namespace roomwise::objects {
namespace {

using network::Classifier;
using network::PixelBox;

// The boxes that hold something, without those of another name that show the same, best first.
std::vector<network::Detection> distinct(std::span<const network::Detection> detections,
                                         float nms_iou) {
  std::vector<network::Detection> kept;
  for (const network::Detection& detection : detections) {
    const bool is_known = std::ranges::any_of(kept, [&](const network::Detection& other) {
      return network::intersection_over_union(detection.box, other.box) > nms_iou;
    });
    if (!is_known && detection.box.area() > 0) kept.push_back(detection);
  }
  return kept;
}

// The labels, by index, of each word that has some.
using LabelsOfWords = std::vector<std::vector<std::size_t>>;
LabelsOfWords labels_of_words(const std::vector<std::string>& labels,
                              const ObjectVocabulary& words) {
  LabelsOfWords of_words;
  for (const auto& [word, unused] : words.objects()) {
    std::vector<std::size_t> of_word;
    for (std::size_t i = 0; i < labels.size(); ++i) {
      if (words.object_of(labels[i]) == word) of_word.push_back(i);
    }
    if (!of_word.empty()) of_words.push_back(std::move(of_word));
  }
  return of_words;
}

struct NamedBox {
  network::Detection found;
  std::size_t word = 0;  // index of LabelsOfWords
  PixelBox square;       // that was cut out
};

// The word that the scores say most, by its likeliest label.
NamedBox best_word(const std::vector<float>& scores, const LabelsOfWords& words) {
  NamedBox best;
  for (std::size_t word = 0; word < words.size(); ++word) {
    float sum = 0;
    for (const std::size_t label : words[word]) sum += scores[label];
    if (!(sum > best.found.score)) continue;  // nor what is no number
    best.word = word;
    best.found.score = sum;
    best.found.label =
        *std::ranges::max_element(words[word], {}, [&](std::size_t i) { return scores[i]; });
  }
  best.found.score = std::min(best.found.score, 1.0F);
  return best;
}

// Best first, given and returned.
std::vector<network::Detection> without_neighbors(std::span<const NamedBox> named) {
  constexpr float kMax = 0.5F;
  std::vector<const NamedBox*> kept;
  for (const NamedBox& one : named) {
    const bool shows_better = std::ranges::any_of(kept, [&](const NamedBox* better) {
      const PixelBox& box = better->found.box;
      return better->word == one.word &&
             network::intersection(one.square, box).area() >= kMax * box.area();
    });
    if (!shows_better) kept.push_back(&one);
  }
  std::vector<network::Detection> found;
  for (const NamedBox* one : kept) found.push_back(one->found);
  return found;
}

Expected<std::vector<network::Detection>> name_boxes(const image::ColorImage& picture,
                                                     std::span<const network::Detection> boxes,
                                                     const Classifier& classifier,
                                                     const LabelsOfWords& words,
                                                     const CropOptions& options) {
  if (picture.empty()) return fail("a picture without pixels has no boxes to name");
  std::vector<NamedBox> named;
  for (const network::Detection& box : distinct(boxes, options.nms_iou)) {
    const PixelBox square =
        square_about(box.box, options.margin, picture.width(), picture.height());
    const int side = static_cast<int>(square.right - square.left);
    ROOMWISE_TRY(const network::Prediction said,
                 classifier.predict(image::crop(picture, static_cast<int>(square.left),
                                                static_cast<int>(square.top), side, side)));
    NamedBox best = best_word(said.scores, words);
    if (best.found.score < options.min_word_score) continue;
    best.found.box = box.box;
    best.square = square;
    named.push_back(best);
  }
  std::ranges::stable_sort(named, std::greater{},
                           [](const NamedBox& one) { return one.found.score; });
  return without_neighbors(named);
}

class CropFinder final : public DetectionFinder {
 public:
  CropFinder(std::shared_ptr<const network::Detector> detector,
             std::shared_ptr<const Classifier> classifier, const ObjectVocabulary& words,
             const CropOptions& options)
      : detector_(std::move(detector)),
        classifier_(std::move(classifier)),
        words_(labels_of_words(classifier_->labels(), words)),
        options_(options),
        name_("crops of boxes") {
    std::vector<std::string> said;  // each word with the labels that mean it here
    for (const auto& [word, of_word] : words.objects()) {
      said.push_back(fmt::format("{} = {}", word, fmt::join(of_word, " | ")));
    }
    fingerprint_ = fmt::format(
        "{}{}{} {}: {}, {}, {}, {}; {}; {}", classifier_->fingerprint(), kCropMethod, kVersion,
        detector_->fingerprint(), options.min_box_score, options.min_word_score, options.margin,
        options.nms_iou, classifier_->preprocessing(), fmt::join(said, ", "));
  }

  [[nodiscard]] const std::string& name() const override { return name_; }
  [[nodiscard]] const std::string& fingerprint() const override { return fingerprint_; }
  [[nodiscard]] const std::vector<std::string>& labels() const override {
    return classifier_->labels();
  }
  [[nodiscard]] Expected<std::vector<network::Detection>> find(
      const image::ColorImage& picture) const override {
    ROOMWISE_TRY(const auto boxes, detector_->detect(picture, options_.min_box_score));
    return name_boxes(picture, boxes, *classifier_, words_, options_);
  }

 private:
  // Counted up where the same options give other regions.
  static constexpr int kVersion = 1;

  std::shared_ptr<const network::Detector> detector_;
  std::shared_ptr<const Classifier> classifier_;
  LabelsOfWords words_;
  CropOptions options_;
  std::string name_, fingerprint_;
};

}  // namespace

PixelBox square_about(const PixelBox& box, float margin, int width_px, int height_px) {
  const float longest = std::max(box.right - box.left, box.bottom - box.top);
  const int side = std::clamp(static_cast<int>(margin * longest), 1, std::min(width_px, height_px));
  const auto begin = [side](float from, float to, int size) {
    return static_cast<float>(
        std::clamp(static_cast<int>((from + to) / 2) - side / 2, 0, size - side));
  };
  const float left = begin(box.left, box.right, width_px);
  const float top = begin(box.top, box.bottom, height_px);
  return {left, top, left + static_cast<float>(side), top + static_cast<float>(side)};
}

ObjectVocabulary classes_of_crops(const std::vector<std::string>& labels,
                                  const ObjectVocabulary& vocabulary) {
  static const std::set<std::string> kFoundRightly{"bath", "bookcase", "lamp",
                                                   "sink", "toaster",  "washing machine"};
  return classes_with_labels(vocabulary, labels,
                             [](const std::string& word) { return kFoundRightly.contains(word); });
}

Expected<std::vector<network::Detection>> crop_regions(const image::ColorImage& picture,
                                                       std::span<const network::Detection> boxes,
                                                       const Classifier& classifier,
                                                       const ObjectVocabulary& words,
                                                       const CropOptions& options) {
  return name_boxes(picture, boxes, classifier, labels_of_words(classifier.labels(), words),
                    options);
}

std::unique_ptr<DetectionFinder> crop_finder(std::shared_ptr<const network::Detector> detector,
                                             std::shared_ptr<const Classifier> classifier,
                                             const ObjectVocabulary& words,
                                             const CropOptions& options) {
  return std::make_unique<CropFinder>(std::move(detector), std::move(classifier), words, options);
}

}  // namespace roomwise::objects
