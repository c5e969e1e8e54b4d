#include "laboratory/trials/instance_fitting.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "laboratory/simulation/recording/simulation_file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/objects/testing/test_room.h"

namespace roomwise::trials {
namespace {

using Eigen::Vector3d;
using objects::testing::TestRoom;

const TestRoom::Thing kChair{"chair", {-0.8, 0, 0.4}, {0.45, 0.45, 0.8}};
const TestRoom::Thing kBed{"bed", {1.0, 0.2, 0.25}, {2.0, 1.4, 0.5}};

evaluation::TrueObject there(const TestRoom::Thing& thing, bool is_expected = true) {
  return {thing.name, {{Eigen::Quaterniond::Identity(), thing.center}, thing.size_m}, is_expected};
}

// A bed and a chair, seen from all sides; two pictures of the bed call it a sofa. `turned` makes
// another room of it.
FittingCase room_case(const std::string& name, bool is_real, double turned_rad,
                      std::vector<evaluation::TrueObject> truth) {
  TestRoom room;
  room.things = {kChair, kBed};
  room.look_around({0.2, 0, 0.3}, 12, 2.4, turned_rad);
  room.things = {kBed};
  for (const double y : {1.2, 1.6}) room.look({2.6, y, 1.4}, kBed.center, true, "sofa");
  return fitting_case(name, is_real, room.keyframes(), std::move(truth));
}

TEST(FittingCase, SaysWhatEachCandidateIs) {
  const FittingCase one = room_case("a", true, 0, {there(kChair), there(kBed, false)});
  ASSERT_FALSE(one.candidate_truth.empty());
  for (std::size_t i = 0; i < one.candidate_truth.size(); ++i) {
    const std::string& name = one.weighed.candidates[i].class_name;
    EXPECT_EQ(one.candidate_truth[i], name == "chair" ? CandidateTruth::kThing
                                      : name == "bed" ? CandidateTruth::kUnasked
                                                      : CandidateTruth::kNothing)
        << name;
  }
}

TEST(FittingCase, WhatStandsInAThingUncountedIsUnasked) {
  evaluation::TrueObject bed = there(kBed);
  bed.holds = {"sofa"};
  const FittingCase one = room_case("a", true, 0, {bed, there(kChair)});
  for (std::size_t i = 0; i < one.candidate_truth.size(); ++i) {
    if (one.weighed.candidates[i].class_name != "sofa") continue;
    EXPECT_EQ(one.candidate_truth[i], CandidateTruth::kUnasked);
  }
}

TEST(FitInstances, FindsInAnotherRoomWhatItLearned) {
  const std::vector<evaluation::TrueObject> truth{there(kChair), there(kBed)};
  const FittingCase real = room_case("a", true, 0, truth);
  const FittingCase simulated = room_case("b", false, 0.2, truth);
  const FittingCase unseen = room_case("c", true, 0.1, truth);
  const std::vector<const FittingCase*> cases{&real, &simulated};
  const auto model = fit_instances(cases, {.weight_penalty = 0.1, .kind_penalty = 0.1});
  ASSERT_OK(model);
  const CaseResult result = measure_case(unseen, *model, 1.0);
  EXPECT_EQ(result.counts.matched, 2U);
  EXPECT_EQ(result.counts.wrong, 0U) << "two pictures make no sofa";
  // The sides that are seen are all alike to the jackknife; what was fitted knows how far that is
  // from the truth.
  EXPECT_GE(result.coverage.two_sigma.value(), 0.8);
  EXPECT_GE(result.coverage.two_sigma.value(),
            measure_case(unseen, with_jackknife_alone(*model), 1.0).coverage.two_sigma.value());
  EXPECT_EQ(std::ranges::count_if(result.forecasts, &evaluation::Forecast::is_right), 2);
  // What is written is what was fitted.
  const std::vector<FittingCase> all{real, simulated};
  const auto read = objects::InstanceModel::parse(to_json(*model, all, {}));
  ASSERT_OK(read);
  EXPECT_NEAR(read->bias, model->bias, 1e-4);
  EXPECT_EQ(read->min_probability, model->min_probability);
  for (std::size_t i = 0; i < objects::kVarianceNames.size(); ++i) {
    EXPECT_NEAR(read->variance_weights[i], model->variance_weights[i], 1e-6);
  }
}

TEST(FitInstances, LeavesOutAllCasesOfASource) {
  const std::vector<evaluation::TrueObject> truth{there(kChair), there(kBed)};
  std::vector<FittingCase> cases{room_case("a", true, 0, truth), room_case("b", true, 0.2, truth),
                                 room_case("c", true, 0.4, {there(kChair)})};
  cases[0].source = cases[1].source = "one recording";
  const auto model = fit_without(cases[0].source, cases, {});
  const auto of_the_third = fit_instances(std::vector<const FittingCase*>{&cases[2]}, {});
  ASSERT_OK(model);
  EXPECT_EQ(to_json(*model, cases, {}), to_json(*of_the_third, cases, {}));
  const std::vector<const FittingCase*> two{&cases[1], &cases[2]};
  EXPECT_NE(model->bias, fit_instances(two, {})->bias);
  cases.pop_back();
  EXPECT_ERROR(fit_without("one recording", cases, {}),
               "all cases are of the source one recording");
}

TEST(PlaceOf, IsTheHomeOrTheRecording) {
  const roomwise::testing::ScratchFolder folder;
  for (const std::uint64_t seed : {101, 102}) {
    for (const char* name : {"day", "evening"}) {
      const auto walk = folder / std::to_string(seed) / name;
      std::filesystem::create_directories(walk);
      simulation::SimulationOptions made;
      made.home.emplace().seed = seed;
      ASSERT_OK(simulation::write_simulation(walk / "simulation.json", {made, ""}));
      EXPECT_EQ(place_of(walk).value(), fmt::format("home {}", seed));
    }
  }
  EXPECT_EQ(place_of(folder / "office_walk/").value(), "office_walk");
  EXPECT_EQ(place_of("office_walk").value(), "office_walk");
  EXPECT_EQ(place_of("truth/bedroom_a.objects.json").value(), "bedroom_a");
}

TEST(FitInstances, NeedsThingsAndWhatIsNone) {
  const FittingCase nothing = room_case("a", true, 0, {});
  const std::vector<const FittingCase*> cases{&nothing};
  EXPECT_ERROR(fit_instances(cases, {}), "0 of ");
}

}  // namespace
}  // namespace roomwise::trials
