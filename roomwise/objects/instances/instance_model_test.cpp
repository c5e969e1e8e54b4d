#include "roomwise/objects/instances/instance_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/objects/testing/test_room.h"

namespace roomwise::objects {
namespace {

using testing::TestRoom;

TEST(InstanceModel, IsALogisticRegressionWithAnInterceptOfTheKind) {
  const auto model = InstanceModel::parse(
      R"({"bias": -1, "min_probability": 0.4, "weights": {"sum of scores": 2, "larger": -1},
          "of_kind": {"chair": 0.5}})");
  ASSERT_OK(model);
  EXPECT_DOUBLE_EQ(model->min_probability, 0.4);
  Evidence evidence{};
  evidence[0] = 1;  // sum of scores
  EXPECT_NEAR(model->probability(evidence, "chair"), 1 / (1 + std::exp(-1.5)), 1e-12);
  EXPECT_NEAR(model->probability(evidence, "dragon"), 1 / (1 + std::exp(-1.0)), 1e-12);
}

TEST(InstanceModel, NamesWhatIsWrong) {
  EXPECT_ERROR(InstanceModel::parse(R"({"bias": 0})"), "min_probability");
  EXPECT_ERROR(InstanceModel::parse(R"({"bias": 0, "min_probability": 0.5, "of_kind": {},
                                        "weights": {"its colour": 1}})"),
               "\"its colour\", which is no evidence");
  EXPECT_ERROR(InstanceModel::parse(R"({"bias": 0, "min_probability": 2, "of_kind": {},
                                        "weights": {}})"),
               "not in [0, 1]");
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
    EXPECT_EQ(evidence(i, "rival"), 3) << "nothing else is there";
    EXPECT_EQ(evidence(i, "on the floor"), 0) << "chairs do stand there";
  }
}

}  // namespace
}  // namespace roomwise::objects
