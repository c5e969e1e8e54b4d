#include "roomwise/network/vision/classifier_quantization.h"

#include <algorithm>

#include "roomwise/network/vision/classifier_outputs.h"
#include "roomwise/network/vision/picture_input.h"

namespace roomwise::network {
namespace {

constexpr std::size_t kMaxPictures = 320;
// One run of neighbours in so many is measured on: the others are not all neighbours of those.
constexpr std::size_t kRun = 4, kMeasuredEvery = 4;

std::string how_near(const QuantizedClassifier& quantized, const ClassifierOutputs& outputs) {
  const QuantizationReport& report = quantized.report;
  std::string text = fmt::format(
      "measured on {} pictures, checked on {} others: cosine of its outputs with "
      "floats {:.4f} in the mean and {:.4f} at worst",
      quantized.measured_on, quantized.checked_on, std::ranges::min(report.mean_cosine),
      std::ranges::min(report.min_cosine));
  if (outputs.scores)
    text += fmt::format(", first label the same for {:.1f} %", 100 * report.agreement.back());
  return text;
}

}  // namespace

Expected<QuantizedClassifier> quantize_classifier(const std::filesystem::path& weights,
                                                  std::size_t pictures, const PictureAt& picture,
                                                  std::size_t threads, const RunsDone& runs_done) {
  const auto in_file = [&](Error error) { return std::move(error).with_context(weights.string()); };
  ROOMWISE_TRY(const NetworkFile file, read_network_in_floats(weights));
  if (file.card.task != Task::kClassify)
    return fail(
        "{}: finds things or words in pictures; 8 bits are for networks that look at whole ones",
        weights.string());
  ROOMWISE_TRY(const ClassifierOutputs outputs, classifier_outputs(file).map_error(in_file));
  if (pictures < kMinQuantizationPictures) {
    return fail("8 bits need at least {} pictures to be measured and checked on, not {}",
                kMinQuantizationPictures, pictures);
  }
  std::vector<Tensor> calibration, held_out;
  const std::size_t taken = std::min(pictures, kMaxPictures);
  for (std::size_t i = 0; i < taken; ++i) {
    ROOMWISE_TRY(const image::ColorImage shown, picture(i * pictures / taken));
    auto& to = i / kRun % kMeasuredEvery == 0 ? calibration : held_out;
    to.push_back(picture_input(shown, file.card));
  }
  ExecutorOptions options;
  options.outputs = outputs.all();
  std::vector<std::size_t> scores;
  if (outputs.scores) scores.push_back(options.outputs.size() - 1);
  ROOMWISE_TRY(CheckedExecutor checked,
               checked_quantization(file.graph, options, calibration, held_out, scores, {}, threads,
                                    runs_done)
                   .map_error(in_file));
  QuantizedClassifier quantized{.report = std::move(checked.report),
                                .measured_on = calibration.size(),
                                .checked_on = held_out.size()};
  quantized.file.network = weights;
  quantized.file.sha256 = file.sha256;
  quantized.file.preprocessing = preprocessing_of(file.card, outputs);
  if (checked.eight_bits) {
    quantized.file.ranges = *std::move(checked.eight_bits);
    quantized.file.checked = how_near(quantized, outputs);
  }
  return quantized;
}

}  // namespace roomwise::network
