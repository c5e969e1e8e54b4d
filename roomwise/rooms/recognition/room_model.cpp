#include "roomwise/rooms/recognition/room_model.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "roomwise/base/own_data.h"
#include "roomwise/rooms/room_model_json.h"

namespace roomwise::rooms {
namespace {

// Of a cosine, in times that of what is usual.
double relative_distance(double cosine, double usual_cosine) {
  constexpr double kSmallest = 1e-6;  // of the very same picture, in floats
  return std::log(std::max(1 - cosine, kSmallest) / std::max(1 - usual_cosine, kSmallest));
}

bool is_finite(const RoomModel& model) {
  return std::isfinite(model.similarity_weight) && std::isfinite(model.regression_weight) &&
         std::isfinite(model.bias) && std::isfinite(model.reject_log_odds) &&
         std::ranges::all_of(model.weights, [](double weight) { return std::isfinite(weight); });
}

RoomModel parse_room_model(const nlohmann::json& json) {
  RoomModel model;
  json.at("network").get_to(model.network);
  json.at("similarity_weight").get_to(model.similarity_weight);
  json.at("regression_weight").get_to(model.regression_weight);
  json.at("bias").get_to(model.bias);
  json.at("min_probability").get_to(model.min_probability);
  json.at("reject_log_odds").get_to(model.reject_log_odds);
  for (std::size_t i = 0; i < kFamiliarityNumbers; ++i) {
    json.at("weights").at(std::string(kFamiliarityNames[i])).get_to(model.weights[i]);
  }
  return model;
}

}  // namespace

FamiliarityNumbers familiarity_numbers(const Similarity& similarity,
                                       const RoomCalibration& calibration) {
  return {similarity.plain_cosine, similarity.whitened_cosine, calibration.whitened_cosine_mean,
          relative_distance(similarity.plain_cosine, calibration.plain_cosine_mean),
          relative_distance(similarity.whitened_cosine, calibration.whitened_cosine_mean)};
}

Eigen::MatrixX2d pooled_opinions(const Similarity& similarity, const Eigen::VectorXd& regression,
                                 const RoomCalibration& calibration) {
  constexpr double kMinRegression = 1e-6;  // no picture rules a room out
  Eigen::MatrixX2d opinions(regression.size(), 2);
  opinions << similarity.of_rooms / calibration.temperature,
      regression.array().max(kMinRegression).log().matrix();
  return opinions;
}

double probability_of(double log_odds) {
  return 1 / (1 + std::exp(-log_odds));
}

Eigen::VectorXd RoomModel::probabilities(const Similarity& similarity,
                                         const Eigen::VectorXd& regression,
                                         const RoomCalibration& calibration) const {
  const Eigen::ArrayXd logs = pooled_opinions(similarity, regression, calibration) *
                              Eigen::Vector2d(similarity_weight, regression_weight);
  const Eigen::ArrayXd powers = (logs - logs.maxCoeff()).exp();
  return powers / powers.sum();
}

double RoomModel::familiarity(const FamiliarityNumbers& numbers) const {
  double log_odds = bias;
  for (std::size_t i = 0; i < numbers.size(); ++i) log_odds += weights[i] * numbers[i];
  return log_odds;
}

Expected<std::vector<RoomModel>> parse_room_models(std::string_view json) {
  std::vector<RoomModel> models;
  try {
    const auto parsed = nlohmann::json::parse(json);
    for (const auto& model : parsed.at("models")) models.push_back(parse_room_model(model));
  } catch (const nlohmann::json::exception& error) {
    return fail("the model of rooms: {}", error.what());
  }
  for (const RoomModel& model : models) {
    if (!is_finite(model)) return fail("the model of rooms: a number is not finite");
    if (!(model.min_probability >= 0.5 && model.min_probability <= 1)) {
      return fail("the model of rooms: min_probability is {}; expected 0.5 to 1",
                  model.min_probability);
    }
  }
  if (models.empty() || !models.back().network.empty()) {
    return fail("the model of rooms: the last of its models is not for any network");
  }
  return models;
}

const RoomModel& RoomModel::of(std::string_view network) {
  static const std::vector<RoomModel> kModels = own_data(parse_room_models(kRoomModelJson));
  return *std::ranges::find_if(
      kModels, [&](const RoomModel& model) { return network.starts_with(model.network); });
}

}  // namespace roomwise::rooms
