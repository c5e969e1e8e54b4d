#include "roomwise/objects/own_things/own_thing_model.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <vector>

#include "roomwise/base/median.h"
#include "roomwise/base/own_data.h"
#include "roomwise/objects/built_in_data.h"

namespace roomwise::objects {

double OwnThingModel::log_odds(const MatchFeatures& likeness) const {
  return std::inner_product(likeness.begin(), likeness.end(), weights.begin(), bias);
}

Expected<OwnThingModel> OwnThingModel::parse(std::string_view json) {
  OwnThingModel model;
  try {
    const auto parsed = nlohmann::json::parse(json);
    parsed.at("bias").get_to(model.bias);
    parsed.at("margin").get_to(model.margin);
    const auto& weights = parsed.at("weights");
    for (std::size_t i = 0; i < kMatchFeatures; ++i) {
      weights.at(std::string(kMatchFeatureNames[i])).get_to(model.weights[i]);
    }
    if (weights.size() != kMatchFeatures) {
      return fail("the model of own things: it weighs {} likenesses; this program knows {}",
                  weights.size(), kMatchFeatures);
    }
  } catch (const nlohmann::json::exception& error) {
    return fail("the model of own things: {}", error.what());
  }
  const bool is_finite =
      std::isfinite(model.bias) && std::isfinite(model.margin) &&
      std::ranges::all_of(model.weights, [](double weight) { return std::isfinite(weight); });
  if (!is_finite) return fail("the model of own things: a number is not finite");
  return model;
}

const OwnThingModel& OwnThingModel::built_in() {
  static const OwnThingModel kModel = own_data(parse(kOwnThingModelJson));
  return kModel;
}

Expected<double> found_threshold(std::vector<double> scores, const OwnThingModel& model) {
  if (scores.size() < kMinCalibrationPictures) {
    return fail("{} pictures of the home do not tell what is usual there; {} do", scores.size(),
                kMinCalibrationPictures);
  }
  return median_of(scores) + model.margin;
}

}  // namespace roomwise::objects
