#include "laboratory/trials/guidance/guidance_trial.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "laboratory/simulation/testing/test_homes.h"
#include "laboratory/trials/guidance/guidance_page.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::trials {
namespace {

using Kind = Instruction::Kind;
using ::testing::HasSubstr;

// Hall and study, with a box in the study (test_homes.h).
simulation::HomeModel two_rooms() {
  simulation::HomeModel home = simulation::square_rooms(2);
  simulation::PlacedObject box = simulation::box_object({7, 3.2, 0});
  box.room = 1;
  box.size_m = {0.6, 0.5, 0.8};
  home.objects.push_back(box);
  return home;
}

simulation::FurnitureModel box_model() {
  simulation::FurnitureModel model;
  model.id = model.kind = model.name = "box";
  return model;
}

class GuidanceTrialTest : public ::testing::Test {
 protected:
  GuidanceTrialTest() {
    const std::vector models{box_model()};
    map_ = map_truth(home_.model, models, 1).value();
  }
  [[nodiscard]] std::vector<GuidedWalk> walks(TrialOptions options) const {
    EXPECT_OK(options.validate());
    std::vector<GuidedWalk> walks;
    const auto goals = choose_goals(*map_, home_, options.goals);
    EXPECT_OK(goals);
    for (std::size_t i = 0; i < goals->size(); ++i) {
      walks.push_back(lead(*map_, home_, (*goals)[i], options, i));
    }
    return walks;
  }

  const WalkedHome home_{two_rooms()};
  std::optional<GuidedMap> map_;
};

TEST_F(GuidanceTrialTest, TheMapHasRoomsDoorAndThings) {
  EXPECT_EQ(map_->layout.rooms().size(), 2u);
  ASSERT_EQ(map_->layout.doorways().size(), 1u);
  EXPECT_NEAR(map_->layout.doorways()[0].middle_gravity.x(), 4.06, 0.2);
  ASSERT_EQ(map_->things.size(), 1u);
  EXPECT_EQ(map_->things[0].room, "study");
}

TEST_F(GuidanceTrialTest, WhoDoesExactlyWhatTheyHearArrives) {
  TrialOptions options;
  options.faults.scale = 0;
  options.position.answered_share = 1;
  options.position.wrong_share = 0;
  const auto all = walks(options);
  const TrialSummary summary = summarise(all);
  EXPECT_EQ(summary.goals, 20u);
  EXPECT_GE(summary.arrived, 19u);
  EXPECT_EQ(summary.says_there_wrongly, 0u);
  EXPECT_GT(summary.spl, 0.65);
}

TEST_F(GuidanceTrialTest, TheSameSeedGivesTheSameWalks) {
  TrialOptions options;
  options.seed = 3;
  options.goals.goals = 4;
  const auto first = walks(options), second = walks(options);
  options.seed = 4;
  const auto other = walks(options);
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].walked_m, second[i].walked_m);
    EXPECT_EQ(first[i].heard.size(), second[i].heard.size());
    EXPECT_NE(first[i].walked_m, other[i].walked_m);
  }
}

TEST(TrialSummaryTest, ArrivalsAreCountedByKindOfGoal) {
  std::vector<GuidedWalk> walks(4);
  walks[0].says_there = walks[0].is_there = true;
  walks[1].says_there = true;
  walks[2].goal.goal.kind = walks[3].goal.goal.kind = guide::Goal::Kind::kRoom;
  walks[3].says_there = walks[3].is_there = true;
  for (GuidedWalk& walk : walks) walk.goal.shortest_m = walk.walked_m = 3;
  const TrialSummary summary = summarise(walks);
  ASSERT_EQ(summary.by_kind.size(), 2u);
  EXPECT_EQ(summary.by_kind.at("thing").goals, 2u);
  EXPECT_EQ(summary.by_kind.at("thing").arrived, 1u);
  EXPECT_EQ(summary.by_kind.at("room").goals, 2u);
  EXPECT_EQ(summary.by_kind.at("room").arrived, 1u);
}

TEST_F(GuidanceTrialTest, ThePageShowsEachWalkWithWhatWasHeard) {
  TrialOptions options;
  options.goals.goals = 2;
  const auto all = walks(options);
  const std::string page = guidance_page(home_, all, "Walks", "modelled");
  EXPECT_THAT(page, HasSubstr("Walk 2: to "));
  EXPECT_THAT(page, HasSubstr(all[0].heard[0].text));
  EXPECT_THAT(page, HasSubstr("<svg"));
}

TEST(InstructionTest, IsWhatWordsAndNumbersSay) {
  const auto catalogue = guide::MessageCatalogue::built_in();
  for (const char* language : {"en", "de"}) {
    const guide::Wording wording{&catalogue, {language, guide::DistanceUnit::kSteps, 0.5}};
    const auto heard = [&](const char* message, const guide::Values& values = {}) {
      return understand(make_prompt(wording, "guide", message, values, guide::Confidence::kSure, 0),
                        wording);
    };
    EXPECT_EQ(heard("guide.turn_left").turn_rad, std::numbers::pi / 2);
    const Instruction hour = heard("guide.turn_hour_right", {{"hour", "4"}});
    EXPECT_EQ(hour.kind, Kind::kTurn);
    EXPECT_NEAR(hour.turn_rad, -std::numbers::pi * 2 / 3, 1e-9);
    const Instruction walk =
        heard("guide.walk_to", {{"distance", "6 steps"}, {"place", guide::thing("door")}});
    EXPECT_EQ(walk.kind, Kind::kWalk);
    EXPECT_EQ(walk.distance_m, 3);
    const Instruction soon = heard("guide.soon_hour", {{"distance", "3 steps"}, {"hour", "10"}});
    EXPECT_EQ(soon.kind, Kind::kSoon);
    EXPECT_EQ(soon.distance_m, 1.5);
    EXPECT_NEAR(soon.turn_rad, std::numbers::pi / 3, 1e-9);
    EXPECT_EQ(heard("guide.off").kind, Kind::kStop);
    EXPECT_EQ(heard("guide.lost").kind, Kind::kLookAround);
    EXPECT_EQ(heard("guide.lost_wait").kind, Kind::kStop);
    const guide::Values into{{"distance", "3 steps"}, {"room", guide::room("bedroom 2")}};
    EXPECT_EQ(heard("guide.into", into).kind, Kind::kWalk);
    EXPECT_EQ(heard("guide.into", into).distance_m, 1.5);
    EXPECT_EQ(heard("guide.soon_into", into).distance_m, 2.5);
    EXPECT_EQ(heard("guide.narrow").kind, Kind::kNothing);
  }
}

TEST_F(GuidanceTrialTest, TheCaneFindsWhatIsInTheWayAndTheWalkerGoesAroundIt) {
  WalkerFaults faults;
  faults.scale = 0;
  SimulatedWalker walker(home_, {5, 3.3}, 0, faults, 1);
  walker.hear({Kind::kWalk, 0, 2.8});
  for (int i = 0; i < 400; ++i) walker.step(0.05);
  EXPECT_GT(walker.walked_m(), 1.5);
  EXPECT_EQ(walker.contacts(), 0);
}

TEST(WalkerFaultsTest, SayWhatIsWrong) {
  EXPECT_OK(WalkerFaults{}.validate());
  EXPECT_ERROR(WalkerFaults{.scale = -1}.validate(), "scale is -1");
  EXPECT_ERROR(PositionModel{.answered_share = 0}.validate(), "answered_share is 0");
}

}  // namespace
}  // namespace roomwise::trials
