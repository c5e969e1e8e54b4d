#include "roomwise/network/vision/classifier_outputs.h"

#include <fmt/ranges.h>

namespace roomwise::network {
namespace {

// Of the way in which picture_input() and OnnxClassifier::predict() do what a card says: counted up
// where a change of theirs gives other features for the same card.
constexpr int kPreprocessingVersion = 1;

// A name with its length before it, so that no two lists of names look alike.
std::string counted(const std::string& name) {
  return fmt::format("{}:{}", name.size(), name);
}

}  // namespace

std::vector<std::string> ClassifierOutputs::all() const {
  std::vector<std::string> names = features;
  if (scores) names.push_back(*scores);
  return names;
}

Expected<ClassifierOutputs> classifier_outputs(const NetworkFile& file) {
  ClassifierOutputs outputs{file.card.features_outputs, std::nullopt};
  if (!file.card.scores_output.empty()) outputs.scores = file.card.scores_output;
  if (!outputs.features.empty() || outputs.scores) return outputs;
  const std::vector<std::string>& given = file.graph.outputs;
  if (given.size() != 1) {
    return fail("the network has {} outputs ({}); name them in \"outputs\" of its card",
                given.size(), fmt::join(given, ", "));
  }
  if (!file.labels.empty()) {
    outputs.scores = given.front();
  } else {
    outputs.features = given;
  }
  return outputs;
}

std::string preprocessing_of(const ModelCard& card, const ClassifierOutputs& outputs) {
  std::vector<std::string> features;
  for (const std::string& output : outputs.features) features.push_back(counted(output));
  return fmt::format(
      "version {}; input {}x{} {} {}; mean {}; scale {}; features {}; scores {}; softmax {}",
      kPreprocessingVersion, card.input_width_px, card.input_height_px,
      card.color_order == ColorOrder::kRgb ? "rgb" : "bgr",
      card.fit == PictureFit::kStretch ? "stretch" : "crop", fmt::join(card.mean, " "),
      fmt::join(card.scale, " "), fmt::join(features, " "),
      outputs.scores ? counted(*outputs.scores) : "none", card.scores_need_softmax);
}

}  // namespace roomwise::network
