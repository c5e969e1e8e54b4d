#include "nanodet.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <opencv2/dnn.hpp>

#include "roomwise/base/file.h"
#include "roomwise/image/resample.h"
#include "roomwise/network/onnx_classifier.h"

namespace roomwise::bench {
namespace {

constexpr std::array kStrides{8, 16, 32, 64};
constexpr std::size_t kBins = 8;
constexpr std::size_t kSides = 4;
constexpr float kSameThing = 0.6F;  // of one label and overlapping more: one thing

// Of blue, green and red: the network takes them in this order.
constexpr std::array kMean{103.53F, 116.28F, 123.675F};
constexpr std::array kDeviation{57.375F, 57.12F, 58.395F};
constexpr std::array<std::uint8_t Rgb8::*, 3> kChannels{&Rgb8::b, &Rgb8::g, &Rgb8::r};

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

// The picture stretched to the input's size, as the network was trained.
cv::Mat input_of(const image::ColorImage& image) {
  const image::ColorImage fitted = image::resize(image, kNanoDetSide, kNanoDetSide);
  const int shape[] = {1, 3, kNanoDetSide, kNanoDetSide};
  cv::Mat input(4, shape, CV_32F);
  for (std::size_t channel = 0; channel < kChannels.size(); ++channel) {
    float* value = input.ptr<float>(0, static_cast<int>(channel));
    for (const Rgb8 pixel : fitted.pixels()) {
      *value++ =
          (static_cast<float>(pixel.*kChannels[channel]) - kMean[channel]) / kDeviation[channel];
    }
  }
  return input;
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

// OpenCV's network runs one picture at a time.
struct NanoDet::Instances {
  Bytes onnx;
  std::mutex mutex;
  std::vector<cv::dnn::Net> idle;

  cv::dnn::Net take() {
    {
      const std::scoped_lock lock(mutex);
      if (!idle.empty()) {
        cv::dnn::Net net = std::move(idle.back());
        idle.pop_back();
        return net;
      }
    }
    cv::dnn::Net net =
        cv::dnn::readNetFromONNX(reinterpret_cast<const char*>(onnx.data()), onnx.size());
    net.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    net.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
    return net;
  }
  void put_back(cv::dnn::Net net) {
    const std::scoped_lock lock(mutex);
    idle.push_back(std::move(net));
  }
};

NanoDet::NanoDet(std::vector<std::string> labels, std::unique_ptr<Instances> instances)
    : labels_(std::move(labels)), instances_(std::move(instances)) {}
NanoDet::~NanoDet() = default;

Expected<std::unique_ptr<NanoDet>> NanoDet::load(const std::filesystem::path& weights,
                                                 const std::filesystem::path& labels) {
  ROOMWISE_TRY(std::vector<std::string> names, network::read_labels(labels));
  auto instances = std::make_unique<Instances>();
  ROOMWISE_TRY(instances->onnx, read_file(weights));
  std::unique_ptr<NanoDet> detector(new NanoDet(std::move(names), std::move(instances)));
  ROOMWISE_CHECK_OK(
      detector->detect(image::ColorImage(kNanoDetSide, kNanoDetSide), 1)
          .map_error([&](Error error) { return std::move(error).in(weights.string()); }));
  return detector;
}

Expected<std::vector<Detection>> NanoDet::detect(const image::ColorImage& image,
                                                 float least_score) const {
  std::vector<Detection> found;
  try {
    cv::dnn::Net net = instances_->take();
    net.setInput(input_of(image));
    const cv::Mat rows = net.forward();
    const std::size_t expected = nanodet_anchors() * (labels_.size() + kSides * kBins);
    if (rows.total() != expected) {
      return fail("is no NanoDet-Plus of {} labels: gives {} values, not {}", labels_.size(),
                  rows.total(), expected);
    }
    found = decode_nanodet({rows.ptr<float>(), rows.total()}, labels_.size(), least_score);
    instances_->put_back(std::move(net));
  } catch (const cv::Exception& exception) {
    return fail("OpenCV cannot run the network: {}", exception.err);
  }
  const float across = static_cast<float>(image.width()) / kNanoDetSide;
  const float down = static_cast<float>(image.height()) / kNanoDetSide;
  for (Detection& detection : found) {
    PixelBox& box = detection.box;
    box = {box.left * across, box.top * down, box.right * across, box.bottom * down};
  }
  return found;
}

}  // namespace roomwise::bench
