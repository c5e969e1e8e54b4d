#include "roomwise/rooms/recognition/room_model.h"

#include <gmock/gmock.h>

#include <cmath>

#include "roomwise/base/testing/testing.h"
#include "roomwise/rooms/room_model_json.h"

namespace roomwise::rooms {
namespace {

Similarity similarity(double first, double second) {
  return {Eigen::Vector2d(first, second), 0.4, 0.9};
}

TEST(RoomModel, PoolsWhatSimilarityAndRegressionSay) {
  RoomModel model;
  model.similarity_weight = 1;
  model.regression_weight = 1;
  RoomCalibration calibration;
  calibration.temperature = 0.1;
  const Eigen::Vector2d alike(0.5, 0.5);
  // Similarities 0.1 apart at a temperature of 0.1: e to 1.
  const Eigen::VectorXd by_similarity =
      model.probabilities(similarity(0.3, 0.2), alike, calibration);
  EXPECT_NEAR(by_similarity[0] / by_similarity[1], std::exp(1), 1e-9);
  const Eigen::VectorXd by_both =
      model.probabilities(similarity(0.3, 0.2), Eigen::Vector2d(0.25, 0.75), calibration);
  EXPECT_NEAR(by_both[0] / by_both[1], std::exp(1) / 3, 1e-9);
  EXPECT_NEAR(by_both.sum(), 1, 1e-12);
  model.regression_weight = 2;
  const Eigen::VectorXd twice =
      model.probabilities(similarity(0.2, 0.2), Eigen::Vector2d(0.25, 0.75), calibration);
  EXPECT_NEAR(twice[1] / twice[0], 9, 1e-9);
}

TEST(RoomModel, ARegressionThatIsCertainRulesNoRoomOut) {
  const Eigen::VectorXd probabilities =
      RoomModel::of("some network")
          .probabilities(similarity(0.9, 0.1), Eigen::Vector2d(0, 1), RoomCalibration{});
  EXPECT_TRUE(probabilities.allFinite());
  EXPECT_GT(probabilities[0], 0);
}

TEST(RoomModel, WhatIsMoreSimilarIsMoreFamiliar) {
  const RoomModel& model = RoomModel::of("some network");
  const RoomCalibration calibration;
  const auto familiarity = [&](double whitened, double plain) {
    return model.familiarity(
        familiarity_numbers({Eigen::Vector2d(0.3, 0.2), whitened, plain}, calibration));
  };
  EXPECT_GT(familiarity(0.4, 0.95), familiarity(0.4, 0.90));
  EXPECT_GT(familiarity(0.5, 0.90), familiarity(0.4, 0.90));
}

TEST(RoomModel, IsThatOfTheNetworkOrOfAnyOther) {
  const RoomModel& trunk = RoomModel::of("inception-2015-12-05-trunk (8 bits)");
  EXPECT_EQ(trunk.network, "inception-2015-12-05-trunk");
  EXPECT_NE(trunk.weights[0], 0);
  const RoomModel& any = RoomModel::of("my own");
  EXPECT_EQ(any.network, "");
  EXPECT_EQ(any.weights[0], 0) << "a cosine means something else there";
}

TEST(RoomModel, IsWhatTheFileSays) {
  const auto parsed = parse_room_models(kRoomModelJson);
  ASSERT_OK(parsed);
  for (const RoomModel& model : *parsed) {
    EXPECT_GT(model.min_probability, 0.5);
    EXPECT_LT(model.reject_log_odds, 0);
  }
}

TEST(RoomModel, NamesWhatIsWrongInAFile) {
  EXPECT_ERROR(parse_room_models("{"), "the model of rooms");
  EXPECT_ERROR(parse_room_models(R"({"models": [{}]})"), "network");
  EXPECT_ERROR(parse_room_models(R"({"models": []})"), "not for any network");
  std::string text(kRoomModelJson);
  const std::string field = "\"min_probability\": ";
  text.replace(text.find(field), field.size(), "\"min_probability\": 1");
  EXPECT_ERROR(parse_room_models(text), "expected 0.5 to 1");
}

TEST(ProbabilityOf, IsTheLogisticFunction) {
  EXPECT_DOUBLE_EQ(probability_of(0), 0.5);
  EXPECT_NEAR(probability_of(std::log(9)), 0.9, 1e-12);
  EXPECT_NEAR(probability_of(3) + probability_of(-3), 1, 1e-12);
}

}  // namespace
}  // namespace roomwise::rooms
