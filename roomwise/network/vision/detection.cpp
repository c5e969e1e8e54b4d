#include "roomwise/network/vision/detection.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace roomwise::network {
namespace {

constexpr std::array kNanoDetStrides{8, 16, 32, 64};
constexpr std::array kYoloStrides{8, 16, 32};
constexpr std::size_t kYolov5Shapes = 3;
constexpr std::size_t kBins = 8;  // of each of NanoDet-Plus' distances
constexpr std::size_t kSides = 4;
constexpr float kSameThing = 0.6F;  // of one label and overlapping more: one thing

std::span<const int> strides_of(Task task) {
  if (task == Task::kNanoDetPlus) return kNanoDetStrides;
  return kYoloStrides;
}

std::size_t shapes_of(Task task) {
  return task == Task::kYolov5 ? kYolov5Shapes : 1;
}

std::size_t values_per_anchor(Task task, std::size_t labels) {
  if (task == Task::kNanoDetPlus) return labels + kSides * kBins;
  return labels + kSides + (task == Task::kYolov8 ? 0 : 1);
}

// Where an anchor's cell lies.
struct Cell {
  float x_px = 0, y_px = 0;  // of its upper left corner
  float stride_px = 0;
};

std::vector<Cell> cells_of(const ModelCard& card) {
  std::vector<Cell> cells;
  for (const int stride : strides_of(card.task)) {
    for (std::size_t shape = 0; shape < shapes_of(card.task); ++shape) {
      for (int y = 0; y < card.input_height_px; y += stride) {
        for (int x = 0; x < card.input_width_px; x += stride) {
          cells.push_back(
              {static_cast<float>(x), static_cast<float>(y), static_cast<float>(stride)});
        }
      }
    }
  }
  return cells;
}

PixelBox box_around(float x, float y, float width, float height) {
  return {x - width / 2, y - height / 2, x + width / 2, y + height / 2};
}

float logistic(float logit) {
  return 1 / (1 + std::exp(-logit));
}

// The mean of a distribution over the bins, given as logits.
float mean_bin(std::span<const float> logits) {
  const float highest = *std::ranges::max_element(logits);
  float sum = 0, weighted = 0;
  for (std::size_t bin = 0; bin < logits.size(); ++bin) {
    const float weight = std::exp(logits[bin] - highest);
    sum += weight;
    weighted += weight * static_cast<float>(bin);
  }
  return weighted / sum;
}

// What one anchor gives, its score and its box by the network's own rules.
class Anchor {
 public:
  // values: this anchor's, `step` apart.
  Anchor(Task task, const Cell& cell, const float* values, std::size_t step, std::size_t labels)
      : task_(task), cell_(cell), values_(values), step_(step), labels_(labels) {}

  // Of the best label; without a box, which only what scores enough is asked for.
  [[nodiscard]] Detection best(float min_score) const {
    const float thing = has_thing() ? at(kSides) : 1;
    if (!(thing > min_score)) return {};
    const std::size_t first = task_ == Task::kNanoDetPlus ? 0 : kSides + (has_thing() ? 1 : 0);
    std::size_t label = 0;
    for (std::size_t i = 1; i < labels_; ++i) {
      if (at(first + i) > at(first + label)) label = i;
    }
    const float score = at(first + label);
    return {label, task_ == Task::kNanoDetPlus ? logistic(score) : thing * score, {}};
  }

  [[nodiscard]] PixelBox box() const {
    switch (task_) {
      case Task::kNanoDetPlus:
        return {cell_.x_px - distance(0), cell_.y_px - distance(1), cell_.x_px + distance(2),
                cell_.y_px + distance(3)};
      case Task::kYolox:
        return box_around(cell_.x_px + cell_.stride_px * at(0),
                          cell_.y_px + cell_.stride_px * at(1), cell_.stride_px * std::exp(at(2)),
                          cell_.stride_px * std::exp(at(3)));
      default:
        return box_around(at(0), at(1), at(2), at(3));
    }
  }

 private:
  [[nodiscard]] float at(std::size_t i) const { return values_[i * step_]; }
  [[nodiscard]] bool has_thing() const { return task_ == Task::kYolox || task_ == Task::kYolov5; }
  [[nodiscard]] float distance(std::size_t side) const {
    return cell_.stride_px * mean_bin({values_ + labels_ + side * kBins, kBins});
  }

  Task task_;
  const Cell& cell_;
  const float* values_;
  std::size_t step_;
  std::size_t labels_;
};

PixelBox inside(const PixelBox& box, const ModelCard& card) {
  return intersection(box, {0, 0, static_cast<float>(card.input_width_px),
                            static_cast<float>(card.input_height_px)});
}

std::vector<Detection> without_repeats(std::vector<Detection> found) {
  std::ranges::stable_sort(found, std::greater{}, &Detection::score);
  std::vector<Detection> kept;
  for (const Detection& detection : found) {
    const bool repeats = std::ranges::any_of(kept, [&](const Detection& better) {
      return better.label == detection.label &&
             intersection_over_union(better.box, detection.box) > kSameThing;
    });
    if (!repeats) kept.push_back(detection);
  }
  return kept;
}

}  // namespace

float PixelBox::area() const {
  return std::max(0.0F, right - left) * std::max(0.0F, bottom - top);
}

PixelBox intersection(const PixelBox& a, const PixelBox& b) {
  return {std::max(a.left, b.left), std::max(a.top, b.top), std::min(a.right, b.right),
          std::min(a.bottom, b.bottom)};
}

float intersection_over_union(const PixelBox& a, const PixelBox& b) {
  const float both = intersection(a, b).area();
  const float either = a.area() + b.area() - both;
  return either > 0 ? both / either : 0;
}

std::size_t detector_output_size(const ModelCard& card, std::size_t labels) {
  return cells_of(card).size() * values_per_anchor(card.task, labels);
}

std::vector<Detection> decode_detections(std::span<const float> output, const ModelCard& card,
                                         std::size_t labels, float min_score) {
  const std::vector<Cell> cells = cells_of(card);
  const bool by_columns = card.task == Task::kYolov8;
  const std::size_t apart = by_columns ? 1 : values_per_anchor(card.task, labels);
  std::vector<Detection> found;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Anchor anchor(card.task, cells[i], output.data() + i * apart,
                        by_columns ? cells.size() : 1, labels);
    Detection detection = anchor.best(min_score);
    if (!(detection.score > min_score)) continue;
    detection.box = inside(anchor.box(), card);
    if (detection.box.area() > 0) found.push_back(detection);
  }
  return without_repeats(std::move(found));
}

}  // namespace roomwise::network
