#include "roomwise/network/vision/onnx_classifier.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <span>

#include "roomwise/network/vision/picture_input.h"

namespace roomwise::network {
namespace {

using image::ColorImage;

// The mean of each channel of a feature map (1 x channels x height x width); other outputs as they
// are.
std::vector<float> pooled_values_of(const Tensor& output) {
  const std::vector<float>& values = output.values;
  if (output.shape.size() != 4 || output.shape[0] != 1) return values;
  const auto channels = static_cast<std::size_t>(output.shape[1]);
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
std::vector<float> join(std::span<const Tensor> outputs) {
  std::vector<float> joined;
  for (const Tensor& output : outputs) {
    std::vector<float> values = pooled_values_of(output);
    if (outputs.size() > 1) scale_to_length_one(values);
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

}  // namespace

Expected<std::unique_ptr<OnnxClassifier>> OnnxClassifier::load(
    const std::filesystem::path& weights, const std::optional<std::filesystem::path>& labels) {
  ROOMWISE_TRY(NetworkFile file, read_network_file(weights, labels));
  return create(std::move(file), weights);
}

Expected<std::unique_ptr<OnnxClassifier>> OnnxClassifier::create(
    NetworkFile file, const std::filesystem::path& weights) {
  const auto in_file = [&](Error error) { return std::move(error).with_context(weights.string()); };
  if (finds_things(file.card.task)) {
    return fail(
        "{}: finds things in pictures, by its card; here a network is wanted that looks at whole "
        "pictures. Detectors look at key-frames by themselves where they are in a folder of "
        "networks",
        weights.string());
  }
  if (file.card.task == Task::kMatchWords) {
    return fail(
        "{}: compares pictures with words, by its card; here a network is wanted that looks at "
        "pictures alone",
        weights.string());
  }
  ROOMWISE_TRY(ClassifierOutputs outputs, classifier_outputs(file).map_error(in_file));
  ExecutorOptions options;
  options.outputs = outputs.all();
  if (file.eight_bits) {
    if (file.eight_bits->preprocessing != preprocessing_of(file.card, outputs)) {
      return fail(
          "{}: was measured with another card of its network than that of now; measure it "
          "anew",
          weights.string());
    }
    options.eight_bits = std::move(file.eight_bits->ranges);
  }
  std::unique_ptr<OnnxClassifier> classifier(new OnnxClassifier());
  ROOMWISE_TRY(classifier->executor_,
               Executor::create(std::move(file.graph), std::move(options)).map_error(in_file));
  classifier->card_ = std::move(file.card);
  classifier->labels_ = std::move(file.labels);
  classifier->fingerprint_ = std::move(file.fingerprint);
  classifier->outputs_ = std::move(outputs);
  ROOMWISE_RETURN_IF_ERROR(classifier->probe().map_error(in_file));
  return classifier;
}

// Runs the network once, to learn what it gives.
Expected<void> OnnxClassifier::probe() {
  ROOMWISE_TRY(const Prediction prediction,
               predict(ColorImage(card_.input_width_px, card_.input_height_px)));
  if (prediction.scores.size() != labels_.size()) {
    return fail("the network gives {} scores, but there are {} labels", prediction.scores.size(),
                labels_.size());
  }
  const auto is_finite = [](float value) { return std::isfinite(value); };
  if (!std::ranges::all_of(prediction.features, is_finite) ||
      !std::ranges::all_of(prediction.scores, is_finite)) {
    return fail("the network gives numbers that are not finite for a black picture");
  }
  feature_size_ = prediction.features.size();
  return {};
}

Expected<Prediction> OnnxClassifier::predict(const ColorImage& image) const {
  if (image.empty()) return fail("the picture has no pixels");
  const Tensor input = picture_input(image, card_);
  ROOMWISE_TRY(std::vector<Tensor> outputs, executor_->run(std::span(&input, 1)));
  Prediction prediction;
  if (outputs_.scores) {
    prediction.scores = std::move(outputs.back().values);
    if (card_.scores_need_softmax && !prediction.scores.empty()) apply_softmax(prediction.scores);
  }
  prediction.features = outputs_.features.empty()
                            ? prediction.scores
                            : join(std::span(outputs).first(outputs_.features.size()));
  if (labels_.empty()) prediction.scores.clear();
  return prediction;
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
