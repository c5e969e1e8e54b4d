#include "roomwise/objects/instances/instance_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/objects/kinds/kinds.h"
#include "roomwise/objects/testing/test_room.h"

namespace roomwise::objects {
namespace {

using testing::TestRoom;

TEST(InstanceModel, IsALogisticRegressionWithAnInterceptOfTheKind) {
  const auto model = InstanceModel::parse(
      R"({"bias": -1, "min_probability": 0.4, "weights": {"sum of scores": 2, "larger": -1},
          "of_kind": {"chair": 0.5}, "variance": {}})");
  ASSERT_OK(model);
  EXPECT_DOUBLE_EQ(model->min_probability, 0.4);
  Evidence evidence{};
  evidence[0] = 1;  // sum of scores
  EXPECT_NEAR(model->probability(evidence, "chair"), 1 / (1 + std::exp(-1.5)), 1e-12);
  EXPECT_NEAR(model->probability(evidence, "dragon"), 1 / (1 + std::exp(-1.0)), 1e-12);
}

Candidate chair_of(const Eigen::Vector3d& size_m) {
  Candidate chair;
  chair.class_name = "chair";
  chair.box_world.size_m = size_m;
  return chair;
}

TEST(InstanceModel, TheVarianceIsASumOfWhatMayCauseIt) {
  const auto model = InstanceModel::parse(
      R"({"bias": 0, "min_probability": 0.5, "weights": {}, "of_kind": {},
          "variance": {"constant": 0.0009, "jackknife": 4, "extent": 0.01,
                       "off usual extent": 0.25}})");
  ASSERT_OK(model);
  const Eigen::Vector3d usual_m = find_kind("chair")->size->usual_m;
  Candidate chair = chair_of({usual_m.y() - 0.2, usual_m.x(), usual_m.z()});
  chair.jackknife_m = {0.05, 0, 0};
  const Eigen::Vector3d sigma_m = model->sigma_m(chair);
  EXPECT_NEAR(sigma_m.x(),
              std::sqrt(0.0009 + 4 * 0.0025 + 0.01 * std::pow(usual_m.y() - 0.2, 2) + 0.25 * 0.04),
              1e-12)
      << "its shorter side is 0.2 m short";
  EXPECT_NEAR(sigma_m.y(), std::sqrt(0.0009 + 0.01 * std::pow(usual_m.x(), 2)), 1e-12);
}

TEST(InstanceModel, OfAThingSeenInPartTheMiddleIsLessSure) {
  const InstanceModel& model = InstanceModel::built_in();
  const Eigen::Vector3d usual_m = find_kind("chair")->size->usual_m;
  const Eigen::Vector3d whole = model.sigma_m(chair_of(usual_m));
  const Eigen::Vector3d part = model.sigma_m(chair_of({0.3, 0.1, 0.3}));
  EXPECT_GT(part.minCoeff(), whole.minCoeff());
  EXPECT_GT(whole.minCoeff(), 0);
}

TEST(InstanceModel, NamesWhatIsWrong) {
  EXPECT_ERROR(InstanceModel::parse(R"({"bias": 0})"), "min_probability");
  EXPECT_ERROR(InstanceModel::parse(R"({"bias": 0, "min_probability": 0.5, "of_kind": {},
                                        "weights": {"its colour": 1}})"),
               "\"its colour\", which is no evidence");
  EXPECT_ERROR(InstanceModel::parse(R"({"bias": 0, "min_probability": 2, "of_kind": {},
                                        "weights": {}, "variance": {}})"),
               "not in [0, 1]");
  EXPECT_ERROR(InstanceModel::parse(R"({"bias": 0, "min_probability": 0.5, "of_kind": {},
                                        "weights": {}, "variance": {"luck": 1}})"),
               "\"luck\", which is no term of the variance");
  EXPECT_ERROR(InstanceModel::parse(R"({"bias": 0, "min_probability": 0.5, "of_kind": {},
                                        "weights": {}, "variance": {"extent": -1}})"),
               "a weight of the variance is negative");
  EXPECT_ERROR(InstanceModel::parse("{"), "the model of instances");
}

TEST(InstanceModel, TheOneThatIsCompiledInKnowsAllEvidence) {
  const InstanceModel& model = InstanceModel::built_in();
  EXPECT_GT(model.weights[0], 0) << "more and surer observations speak for a thing";
  EXPECT_GT(model.min_probability, 0);
  EXPECT_FALSE(model.bias_of_kind.empty());
}

TEST(Evidence, ATwinInTheSamePlaceIsSeenAsOne) {
  TestRoom room;
  room.things = {{"chair", {-0.5, 0, 0.4}, {0.45, 0.45, 0.8}},
                 {"chair", {0.2, 0, 0.4}, {0.45, 0.45, 0.8}}};
  room.look_around({-0.15, 0, 0.4}, 10);
  room.things.pop_back();
  room.look_around({-0.5, 0, 0.4}, 2, 1.2, 2.5, 0.5);  // the first one alone
  const WeighedCandidates weighed =
      weigh_candidates(room.keyframes(), {Eigen::Vector3d::UnitZ(), 0, true}, {});
  ASSERT_EQ(weighed.candidates.size(), 2U);
  const auto evidence = [&](std::size_t i, std::string_view name) {
    const auto place = std::ranges::find(kEvidenceNames, name);
    return weighed.evidence[i].at(static_cast<std::size_t>(place - kEvidenceNames.begin()));
  };
  // The weaker one has the stronger one for its twin, and is seen beside it.
  const std::size_t weaker = evidence(0, "sum of scores") < evidence(1, "sum of scores") ? 0 : 1;
  EXPECT_GE(evidence(weaker, "with the twin"), 0.5);
  EXPECT_EQ(evidence(1 - weaker, "with the twin"), 0) << "the stronger one has none";
  for (const std::size_t i : {0U, 1U}) {
    EXPECT_GT(evidence(i, "rival"), 3) << "nothing else is there";
    EXPECT_EQ(evidence(i, "on the floor"), 0) << "chairs do stand there";
  }
}

TEST(Evidence, WhatFewOfTheViewsShowIsSeenInASmallShare) {
  TestRoom room;
  room.things = {{"chair", {0, 0, 0.4}, {0.45, 0.45, 0.8}}};
  room.look_around({0, 0, 0.4}, 3, 1.8, 0, 0.3);
  room.look_around({0, 0, 0.4}, 9, 1.8, 0, 0.3, false);  // the finder misses it there
  const WeighedCandidates weighed =
      weigh_candidates(room.keyframes(), {Eigen::Vector3d::UnitZ(), 0, true}, {});
  ASSERT_EQ(weighed.candidates.size(), 1U);
  EXPECT_EQ(weighed.visibility[0].observed, 3);
  EXPECT_EQ(weighed.visibility[0].missed, 9);
  const auto share = std::ranges::find(kEvidenceNames, "seen share") - kEvidenceNames.begin();
  EXPECT_DOUBLE_EQ(weighed.evidence[0].at(static_cast<std::size_t>(share)), 0.25);
}

TEST(Evidence, OnePictureMakesNoCandidateHoweverManyBoxesItHas) {
  TestRoom room;
  room.things = {{"chair", {0, 0, 0.4}, {0.45, 0.45, 0.8}}};
  room.look_around({0, 0, 0.4}, 1);
  auto& detections = room.keyframes()[0].detections;
  detections.push_back(detections.front());
  const WeighedCandidates weighed =
      weigh_candidates(room.keyframes(), {Eigen::Vector3d::UnitZ(), 0, true}, {});
  EXPECT_EQ(weighed.observations.size(), 2U);
  EXPECT_TRUE(weighed.candidates.empty());
}

}  // namespace
}  // namespace roomwise::objects
