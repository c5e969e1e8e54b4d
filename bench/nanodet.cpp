#include "nanodet.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "roomwise/base/file.h"
#include "roomwise/network/executor.h"
#include "roomwise/network/onnx_classifier.h"
#include "roomwise/network/picture_input.h"

namespace roomwise::bench {
namespace {

constexpr std::array kStrides{8, 16, 32, 64};
constexpr std::size_t kBins = 8;
constexpr std::size_t kSides = 4;
constexpr float kSameThing = 0.6F;  // of one label and overlapping more: one thing

// The picture is stretched to the input's size, as the network was trained.
network::ModelCard card() {
  network::ModelCard card;
  card.input_width_px = card.input_height_px = kNanoDetSide;
  card.color_order = network::ColorOrder::kBgr;
  card.mean = {103.53F, 116.28F, 123.675F};
  card.scale = {1 / 57.375F, 1 / 57.12F, 1 / 58.395F};
  return card;
}

int cells_of(int stride) {
  return (kNanoDetSide + stride - 1) / stride;
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

PixelBox box_of(std::span<const float> logits, float x, float y, float stride) {
  const auto distance = [&](std::size_t side) {
    return stride * mean_bin(logits.subspan(side * kBins, kBins));
  };
  const auto inside = [](float value) {
    return std::clamp(value, 0.0F, static_cast<float>(kNanoDetSide));
  };
  return {inside(x - distance(0)), inside(y - distance(1)), inside(x + distance(2)),
          inside(y + distance(3))};
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

float intersection_over_union(const PixelBox& a, const PixelBox& b) {
  const PixelBox both{std::max(a.left, b.left), std::max(a.top, b.top), std::min(a.right, b.right),
                      std::min(a.bottom, b.bottom)};
  const float either = a.area() + b.area() - both.area();
  return either > 0 ? both.area() / either : 0;
}

std::size_t nanodet_anchors() {
  std::size_t anchors = 0;
  for (const int stride : kStrides) {
    anchors +=
        static_cast<std::size_t>(cells_of(stride)) * static_cast<std::size_t>(cells_of(stride));
  }
  return anchors;
}

std::vector<Detection> decode_nanodet(std::span<const float> rows, std::size_t labels,
                                      float least_score) {
  std::vector<Detection> found;
  const std::size_t row_size = labels + kSides * kBins;
  std::size_t anchor = 0;
  for (const int stride : kStrides) {
    for (int y = 0; y < cells_of(stride); ++y) {
      for (int x = 0; x < cells_of(stride); ++x, ++anchor) {
        const auto row = rows.subspan(anchor * row_size, row_size);
        const auto logits = row.first(labels);
        const auto best = std::ranges::max_element(logits);
        const float score = 1 / (1 + std::exp(-*best));
        if (!(score > least_score)) continue;
        found.push_back({static_cast<std::size_t>(best - logits.begin()), score,
                         box_of(row.subspan(labels), static_cast<float>(x * stride),
                                static_cast<float>(y * stride), static_cast<float>(stride))});
      }
    }
  }
  return without_repeats(std::move(found));
}

NanoDet::NanoDet(std::vector<std::string> labels, std::unique_ptr<network::Executor> executor)
    : labels_(std::move(labels)), executor_(std::move(executor)) {}

Expected<std::unique_ptr<NanoDet>> NanoDet::load(const std::filesystem::path& weights,
                                                 const std::filesystem::path& labels) {
  const auto in_file = [&](Error error) { return std::move(error).in(weights.string()); };
  ROOMWISE_TRY(std::vector<std::string> names, network::read_labels(labels));
  ROOMWISE_TRY(const Bytes onnx, read_file(weights));
  ROOMWISE_TRY(network::OnnxGraph graph, network::read_onnx_graph(onnx).map_error(in_file));
  ROOMWISE_TRY(auto executor, network::Executor::create(std::move(graph)).map_error(in_file));
  std::unique_ptr<NanoDet> detector(new NanoDet(std::move(names), std::move(executor)));
  ROOMWISE_CHECK_OK(
      detector->detect(image::ColorImage(kNanoDetSide, kNanoDetSide), 1).map_error(in_file));
  return detector;
}

Expected<std::vector<Detection>> NanoDet::detect(const image::ColorImage& image,
                                                 float least_score) const {
  const network::Tensor input = network::picture_input(image, card());
  ROOMWISE_TRY(const std::vector<network::Tensor> outputs, executor_->run({&input, 1}));
  const std::vector<float>& rows = outputs.front().values;
  const std::size_t expected = nanodet_anchors() * (labels_.size() + kSides * kBins);
  if (rows.size() != expected) {
    return fail("is no NanoDet-Plus of {} labels: gives {} values, not {}", labels_.size(),
                rows.size(), expected);
  }
  std::vector<Detection> found = decode_nanodet(rows, labels_.size(), least_score);
  const float across = static_cast<float>(image.width()) / kNanoDetSide;
  const float down = static_cast<float>(image.height()) / kNanoDetSide;
  for (Detection& detection : found) {
    PixelBox& box = detection.box;
    box = {box.left * across, box.top * down, box.right * across, box.bottom * down};
  }
  return found;
}

}  // namespace roomwise::bench
