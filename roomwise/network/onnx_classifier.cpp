#include "roomwise/network/onnx_classifier.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <mutex>
#include <numeric>
#include <opencv2/dnn.hpp>
#include <span>

#include "roomwise/base/file.h"
#include "roomwise/image/resample.h"
#include "roomwise/network/onnx_inputs.h"

namespace roomwise::network {
namespace {

using image::ColorImage;

// The largest centred part of the image that has the proportions of width x height.
ColorImage center_crop(const ColorImage& image, int width, int height) {
  const auto scaled = [](int side, int numerator, int denominator) {
    return std::max(1, static_cast<int>(static_cast<std::int64_t>(side) * numerator / denominator));
  };
  const int crop_width = std::min(image.width(), scaled(image.height(), width, height));
  const int crop_height = std::min(image.height(), scaled(image.width(), height, width));
  return image::crop(image, (image.width() - crop_width) / 2, (image.height() - crop_height) / 2,
                     crop_width, crop_height);
}

// Which colour the input's first, second and third channel hold.
std::uint8_t Rgb8::*channel_of(ColorOrder order, std::size_t channel) {
  if (channel == 1) return &Rgb8::g;
  return (order == ColorOrder::kRgb) == (channel == 0) ? &Rgb8::r : &Rgb8::b;
}

// The picture as the network takes it: 1 x 3 x height x width.
cv::Mat input_of(const ColorImage& image, const ModelCard& card) {
  const int width = card.input_width_px;
  const int height = card.input_height_px;
  const ColorImage fitted =
      image::resize(card.fit == PictureFit::kCenterCrop ? center_crop(image, width, height) : image,
                    width, height);
  const int shape[] = {1, 3, height, width};
  cv::Mat input(4, shape, CV_32F);
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const auto color = channel_of(card.color_order, channel);
    float* value = input.ptr<float>(0, static_cast<int>(channel));
    for (const Rgb8 pixel : fitted.pixels()) {
      *value++ = (static_cast<float>(pixel.*color) - card.mean[channel]) * card.scale[channel];
    }
  }
  return input;
}

std::vector<float> values_of(const cv::Mat& blob) {
  if (blob.empty()) return {};
  return {blob.ptr<float>(), blob.ptr<float>() + blob.total()};
}

// The mean of each channel of a feature map (1 x channels x height x width); other blobs as they
// are.
std::vector<float> pooled_values_of(const cv::Mat& blob) {
  std::vector<float> values = values_of(blob);
  if (blob.dims != 4 || blob.size[0] != 1) return values;
  const auto channels = static_cast<std::size_t>(blob.size[1]);
  const std::size_t places = values.size() / std::max<std::size_t>(channels, 1);
  std::vector<float> means;
  for (std::size_t channel = 0; channel < channels && places > 0; ++channel) {
    const auto begin = values.begin() + static_cast<std::ptrdiff_t>(channel * places);
    const double sum = std::accumulate(begin, begin + static_cast<std::ptrdiff_t>(places), 0.0);
    means.push_back(static_cast<float>(sum / static_cast<double>(places)));
  }
  return means;
}

void scale_to_length_one(std::vector<float>& values) {
  double squared = 0;
  for (const float value : values) squared += static_cast<double>(value) * value;
  if (!(squared > 0)) return;
  for (float& value : values) value = static_cast<float>(value / std::sqrt(squared));
}

// Several outputs are joined so that each counts the same, however large its values are.
std::vector<float> join(std::span<const cv::Mat> blobs) {
  std::vector<float> joined;
  for (const cv::Mat& blob : blobs) {
    std::vector<float> values = pooled_values_of(blob);
    if (blobs.size() > 1) scale_to_length_one(values);
    joined.insert(joined.end(), values.begin(), values.end());
  }
  return joined;
}

void apply_softmax(std::vector<float>& scores) {
  const float highest = *std::max_element(scores.begin(), scores.end());
  double sum = 0;
  for (float& score : scores) {
    score = std::exp(score - highest);
    sum += score;
  }
  for (float& score : scores) score = static_cast<float>(score / sum);
}

// OpenCV's errors have several lines; ours have one.
std::string first_line(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

// OpenCV names the layer of an ONNX node after the node, or after its output where it has no name.
Expected<std::string> layer_named(cv::dnn::Net& net, const std::string& output) {
  for (const char* prefix : {"", "onnx_node!", "onnx_node_output_0!"}) {
    if (net.getLayerId(prefix + output) > 0) return prefix + output;
  }
  return fail("the network has no output or node named \"{}\"; its outputs are {}", output,
              fmt::join(net.getUnconnectedOutLayersNames(), ", "));
}

// The layers to read.
struct Outputs {
  std::vector<std::string> features;
  std::optional<std::string> scores;
};

Expected<Outputs> find_outputs(cv::dnn::Net& net, const ModelCard& card, bool has_labels) {
  Outputs outputs;
  if (card.features_outputs.empty() && card.scores_output.empty()) {
    const std::vector<cv::String> names = net.getUnconnectedOutLayersNames();
    if (names.size() != 1) {
      return fail("the network has {} outputs ({}); name them in \"outputs\" of its card",
                  names.size(), fmt::join(names, ", "));
    }
    if (has_labels) {
      outputs.scores = names.front();
    } else {
      outputs.features = names;
    }
  }
  for (const std::string& output : card.features_outputs) {
    ROOMWISE_TRY(std::string layer, layer_named(net, output));
    outputs.features.push_back(std::move(layer));
  }
  if (!card.scores_output.empty()) {
    ROOMWISE_TRY(outputs.scores, layer_named(net, card.scores_output));
  }
  return outputs;
}

std::string shape_text(const std::vector<std::int64_t>& shape) {
  std::string text;
  for (const std::int64_t size : shape) {
    text += text.empty() ? "" : "x";
    text += size == OnnxInput::kFree ? "?" : fmt::format("{}", size);
  }
  return text.empty() ? "of a single number" : text;
}

// That the network takes one colour picture of the card's size.
Expected<void> check_input(const Bytes& onnx, const ModelCard& card) {
  ROOMWISE_TRY(const std::vector<OnnxInput> inputs, read_onnx_inputs(onnx));
  if (inputs.size() != 1) {
    return fail("the network has {} inputs; expected one, a colour picture", inputs.size());
  }
  const std::vector<std::int64_t> expected = {1, 3, card.input_height_px, card.input_width_px};
  const auto fits = [](std::int64_t given, std::int64_t wanted) {
    return given == OnnxInput::kFree || given == wanted;
  };
  if (!std::ranges::equal(inputs[0].shape, expected, fits)) {
    return fail(
        "the network does not take a colour picture as its card says: its input \"{}\" has the "
        "shape {}; expected {} (batch x channels x height x width)",
        inputs[0].name, shape_text(inputs[0].shape), shape_text(expected));
  }
  return {};
}

Expected<cv::dnn::Net> read_network(const Bytes& onnx) {
  try {
    cv::dnn::Net net =
        cv::dnn::readNetFromONNX(reinterpret_cast<const char*>(onnx.data()), onnx.size());
    if (net.empty()) return fail("holds no network");
    net.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    net.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
    return net;
  } catch (const std::exception& exception) {
    return fail("is an ONNX network that OpenCV cannot read: {}", first_line(exception.what()));
  }
}

Expected<std::vector<std::string>> labels_for(const ModelCard& card,
                                              const std::filesystem::path& weights,
                                              const std::optional<std::filesystem::path>& labels) {
  if (labels) return read_labels(*labels);
  if (card.labels_file.empty()) return std::vector<std::string>{};
  const std::filesystem::path beside = weights.parent_path() / card.labels_file;
  std::error_code ignored;
  if (!std::filesystem::exists(beside, ignored)) {
    return fail("{}: its labels are missing; put {} there or name the file with its labels",
                weights.string(), beside.string());
  }
  return read_labels(beside);
}

}  // namespace

class OnnxClassifier::Implementation {
 public:
  Implementation(ModelCard card, std::vector<std::string> labels, Bytes onnx, cv::dnn::Net net,
                 Outputs outputs)
      : card_(std::move(card)),
        labels_(std::move(labels)),
        onnx_(std::move(onnx)),
        fingerprint_(sha256_hex(onnx_)),
        outputs_(std::move(outputs)) {
    idle_.push_back(std::move(net));
  }

  // Runs the network once, to learn what it gives and that it takes pictures at all.
  Expected<void> probe() {
    ROOMWISE_TRY(const Prediction prediction,
                 predict(ColorImage(card_.input_width_px, card_.input_height_px)));
    if (prediction.scores.size() != labels_.size()) {
      return fail("the network gives {} scores, but there are {} labels", prediction.scores.size(),
                  labels_.size());
    }
    feature_size_ = prediction.features.size();
    return {};
  }

  Expected<Prediction> predict(const ColorImage& image) const {
    if (image.empty()) return fail("the picture has no pixels");
    ROOMWISE_TRY(cv::dnn::Net net, take_instance());
    Prediction prediction;
    try {
      prediction = run(net, input_of(image, card_));
    } catch (const cv::Exception& exception) {
      // The instance may be broken: it is not put back.
      return fail("OpenCV cannot run the network: {}", first_line(exception.what()));
    }
    put_back(std::move(net));
    return prediction;
  }

  [[nodiscard]] const ModelCard& card() const { return card_; }
  [[nodiscard]] const std::vector<std::string>& labels() const { return labels_; }
  [[nodiscard]] const std::string& fingerprint() const { return fingerprint_; }
  [[nodiscard]] std::size_t feature_size() const { return feature_size_; }

 private:
  Prediction run(cv::dnn::Net& net, const cv::Mat& input) const {
    std::vector<cv::String> layers = outputs_.features;
    if (outputs_.scores) layers.push_back(*outputs_.scores);
    std::vector<cv::Mat> blobs;
    net.setInput(input);
    net.forward(blobs, layers);

    Prediction prediction;
    if (outputs_.scores) {
      prediction.scores = values_of(blobs.back());
      if (card_.scores_need_softmax && !prediction.scores.empty()) apply_softmax(prediction.scores);
    }
    prediction.features = outputs_.features.empty()
                              ? prediction.scores
                              : join(std::span(blobs).first(outputs_.features.size()));
    if (labels_.empty()) prediction.scores.clear();
    return prediction;
  }

  Expected<cv::dnn::Net> take_instance() const {
    {
      const std::scoped_lock lock(mutex_);
      if (!idle_.empty()) {
        cv::dnn::Net net = std::move(idle_.back());
        idle_.pop_back();
        return net;
      }
    }
    return read_network(onnx_);
  }

  void put_back(cv::dnn::Net net) const {
    const std::scoped_lock lock(mutex_);
    idle_.push_back(std::move(net));
  }

  ModelCard card_;
  std::vector<std::string> labels_;
  Bytes onnx_;
  std::string fingerprint_;
  Outputs outputs_;
  std::size_t feature_size_ = 0;
  mutable std::mutex mutex_;
  mutable std::vector<cv::dnn::Net> idle_;  // instances that no thread holds
};

OnnxClassifier::OnnxClassifier(std::unique_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}
OnnxClassifier::~OnnxClassifier() = default;

Expected<std::unique_ptr<OnnxClassifier>> OnnxClassifier::load(
    const std::filesystem::path& weights, const std::optional<std::filesystem::path>& labels) {
  const auto in_file = [&](Error error) { return std::move(error).in(weights.string()); };
  ROOMWISE_TRY(Bytes onnx, read_file(weights));
  ROOMWISE_TRY(ModelCard card, find_model_card(weights));
  ROOMWISE_TRY(std::vector<std::string> names, labels_for(card, weights, labels));
  ROOMWISE_CHECK_OK(check_input(onnx, card).map_error(in_file));
  ROOMWISE_TRY(cv::dnn::Net net, read_network(onnx).map_error(in_file));
  ROOMWISE_TRY(Outputs outputs, find_outputs(net, card, !names.empty()).map_error(in_file));
  auto implementation = std::make_unique<Implementation>(
      std::move(card), std::move(names), std::move(onnx), std::move(net), std::move(outputs));
  ROOMWISE_CHECK_OK(implementation->probe().map_error(in_file));
  return std::unique_ptr<OnnxClassifier>(new OnnxClassifier(std::move(implementation)));
}

const std::string& OnnxClassifier::name() const {
  return implementation_->card().name;
}
const std::string& OnnxClassifier::fingerprint() const {
  return implementation_->fingerprint();
}
const std::vector<std::string>& OnnxClassifier::labels() const {
  return implementation_->labels();
}
std::size_t OnnxClassifier::feature_size() const {
  return implementation_->feature_size();
}
Expected<Prediction> OnnxClassifier::predict(const image::ColorImage& image) const {
  return implementation_->predict(image);
}
const ModelCard& OnnxClassifier::card() const {
  return implementation_->card();
}

Expected<std::vector<std::string>> read_labels(const std::filesystem::path& path) {
  ROOMWISE_TRY(const std::string text, read_text_file(path));
  std::vector<std::string> labels;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string label = text.substr(begin, end - begin);
    if (label.ends_with('\r')) label.pop_back();
    begin = end + 1;
    if (label.empty()) {
      return fail("{}:{}: the line is empty; expected a label", path.string(), labels.size() + 1);
    }
    labels.push_back(std::move(label));
  }
  if (labels.empty()) return fail("{}: holds no label; expected one a line", path.string());
  return labels;
}

std::optional<std::filesystem::path> default_model_folder() {
  if (const char* folder = std::getenv("ROOMWISE_MODELS"); folder != nullptr && *folder != '\0') {
    return folder;
  }
  std::error_code ignored;
  const std::filesystem::path shared = "../shared/models";
  if (std::filesystem::is_directory(shared, ignored)) return shared;
  return std::nullopt;
}

}  // namespace roomwise::network
