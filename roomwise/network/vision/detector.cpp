#include "roomwise/network/vision/detector.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "roomwise/network/formats/network_file.h"
#include "roomwise/network/vision/picture_input.h"

namespace roomwise::network {
namespace {

constexpr std::array kStrides{8, 16, 32, 64};
constexpr std::size_t kBins = 8;
constexpr std::size_t kSides = 4;
constexpr float kSameThing = 0.6F;  // of one label and overlapping more: one thing

int cells_along(int side_px, int stride) {
  return (side_px + stride - 1) / stride;
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

PixelBox box_of(std::span<const float> logits, float x, float y, float stride,
                const ModelCard& card) {
  const auto distance = [&](std::size_t side) {
    return stride * mean_bin(logits.subspan(side * kBins, kBins));
  };
  const auto inside = [](float value, int side_px) {
    return std::clamp(value, 0.0F, static_cast<float>(side_px));
  };
  return {
      inside(x - distance(0), card.input_width_px), inside(y - distance(1), card.input_height_px),
      inside(x + distance(2), card.input_width_px), inside(y + distance(3), card.input_height_px)};
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

std::size_t nanodet_anchors(const ModelCard& card) {
  std::size_t anchors = 0;
  for (const int stride : kStrides) {
    anchors += static_cast<std::size_t>(cells_along(card.input_width_px, stride)) *
               static_cast<std::size_t>(cells_along(card.input_height_px, stride));
  }
  return anchors;
}

std::vector<Detection> decode_nanodet(std::span<const float> rows, const ModelCard& card,
                                      std::size_t labels, float min_score) {
  std::vector<Detection> found;
  const std::size_t row_size = labels + kSides * kBins;
  std::size_t anchor = 0;
  for (const int stride : kStrides) {
    for (int y = 0; y < cells_along(card.input_height_px, stride); ++y) {
      for (int x = 0; x < cells_along(card.input_width_px, stride); ++x, ++anchor) {
        const auto row = rows.subspan(anchor * row_size, row_size);
        const auto logits = row.first(labels);
        const auto best = std::ranges::max_element(logits);
        const float score = 1 / (1 + std::exp(-*best));
        if (!(score > min_score)) continue;
        found.push_back({static_cast<std::size_t>(best - logits.begin()), score,
                         box_of(row.subspan(labels), static_cast<float>(x * stride),
                                static_cast<float>(y * stride), static_cast<float>(stride), card)});
      }
    }
  }
  return without_repeats(std::move(found));
}

Expected<std::unique_ptr<Detector>> Detector::load(
    const std::filesystem::path& weights, const std::optional<std::filesystem::path>& labels) {
  const auto in_file = [&](Error error) { return std::move(error).in(weights.string()); };
  ROOMWISE_TRY(NetworkFile file, read_network_in_floats(weights, labels));
  if (file.card.task != Task::kNanoDetPlus) {
    return fail("{}: its card does not say that it finds things (\"task\": \"nanodet-plus\")",
                weights.string());
  }
  if (file.labels.empty()) return fail("{}: a detector needs labels", weights.string());
  std::unique_ptr<Detector> detector(new Detector());
  ROOMWISE_TRY(detector->executor_, Executor::create(std::move(file.graph)).map_error(in_file));
  detector->card_ = std::move(file.card);
  detector->labels_ = std::move(file.labels);
  detector->fingerprint_ = std::move(file.fingerprint);
  const image::ColorImage black(detector->card().input_width_px, detector->card().input_height_px);
  ROOMWISE_CHECK_OK(detector->detect(black, 1).map_error(in_file));
  return detector;
}

Expected<std::vector<Detection>> Detector::detect(const image::ColorImage& image,
                                                  float min_score) const {
  if (image.empty()) return fail("the picture has no pixels");
  const Tensor input = picture_input(image, card_);
  ROOMWISE_TRY(const std::vector<Tensor> outputs, executor_->run({&input, 1}));
  const std::vector<float>& rows = outputs.front().values;
  const std::size_t expected = nanodet_anchors(card_) * (labels_.size() + kSides * kBins);
  if (outputs.size() != 1 || rows.size() != expected) {
    return fail("is no NanoDet-Plus of {} labels: gives {} values, not {}", labels_.size(),
                rows.size(), expected);
  }
  std::vector<Detection> found = decode_nanodet(rows, card_, labels_.size(), min_score);
  const float across = static_cast<float>(image.width()) / static_cast<float>(card_.input_width_px);
  const float down = static_cast<float>(image.height()) / static_cast<float>(card_.input_height_px);
  for (Detection& detection : found) {
    PixelBox& box = detection.box;
    box = {box.left * across, box.top * down, box.right * across, box.bottom * down};
  }
  return found;
}

}  // namespace roomwise::network
