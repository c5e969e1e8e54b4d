#include "roomwise/live/device/trial_question.h"

#include <gmock/gmock.h>

#include <set>

#include "roomwise/guide/answers/spot_prompts.h"

namespace roomwise::live {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// A floor of 6 m by 4 m that is free, with a stove at its right end.
std::shared_ptr<HomeView> home_with_stove() {
  LiveMap map;
  map.floor.emplace(Eigen::Vector2d(-1, -2), 0.05,
                    image::Image<fusion::FloorCell>(120, 80, fusion::FloorCell::kFree));
  auto home = std::make_shared<HomeView>();
  home->map = std::make_shared<const LiveMap>(std::move(map));
  guide::KnownThing stove;
  stove.name = "stove";
  stove.probability = 0.99;
  stove.position_plan = Eigen::Vector3d(4, 0, 0.5);
  stove.box_keyframe.size_m = {0.5, 0.5, 0.9};
  home->things = {stove};
  return home;
}

TrialQuestion question(const std::string& text, std::optional<Eigen::Vector2d> place = {}) {
  TrialQuestion asked;
  asked.text = text;
  asked.place = place;
  return asked;
}

TEST(TrialQuestion, IsAnsweredFromThePlaceWhereOneWouldStand) {
  const auto home = home_with_stove();
  const TrialAnswer ahead = try_question(question("where is the stove", {{1, 0}}), home);
  ASSERT_FALSE(ahead.prompts.empty());
  EXPECT_THAT(ahead.prompts.front().text, HasSubstr("12 o'clock"));
  EXPECT_THAT(ahead.way, IsEmpty());
  TrialQuestion turned = question("where is the stove", {{1, 0}});
  turned.heading_degrees = 90;
  EXPECT_THAT(try_question(turned, home).prompts.front().text, HasSubstr("3 o'clock"));
}

TEST(TrialQuestion, ShowsTheWayOfWhoWouldBeLed) {
  const TrialAnswer led =
      try_question(question("take me to the stove", {{0, 0}}), home_with_stove());
  ASSERT_THAT(led.prompts, SizeIs(1));
  EXPECT_THAT(led.prompts.front().text, HasSubstr("stove"));
  ASSERT_GE(led.way.size(), 2U);
  EXPECT_LT((led.way.front() - Eigen::Vector2d(0, 0)).norm(), 0.1);
  EXPECT_GT(led.way.back().x(), 2.5);
  ASSERT_TRUE(led.goal);
  EXPECT_NEAR(led.goal->x(), 3.75, 0.1) << "the stove's near side";
}

TEST(TrialQuestion, TellsAllThatWhoIsLedHearsUntilTheyAreThere) {
  TrialQuestion asked = question("take me to the stove", {{0, 0}});
  asked.heading_degrees = 90;
  const TrialAnswer led = try_question(asked, home_with_stove());
  ASSERT_GE(led.along_way.size(), 2U);
  EXPECT_EQ(led.along_way.back().message_id, "guide.there_ahead") << led.along_way.back().text;
  std::set<std::string> texts;
  for (const guide::Prompt& prompt : led.along_way) texts.insert(prompt.text);
  EXPECT_EQ(texts.size(), led.along_way.size()) << "each is said once";
  EXPECT_THAT(try_question(question("where is the stove", {{0, 0}}), home_with_stove()).along_way,
              IsEmpty());
}

TEST(TrialQuestion, WithoutAPlaceOneIsToldWhatWhoShowsNoPictureIsTold) {
  const TrialAnswer led = try_question(question("take me to the stove"), home_with_stove());
  EXPECT_FALSE(led.prompts.empty());
  EXPECT_THAT(led.way, IsEmpty());
}

TEST(TrialQuestion, SpeaksTheLanguageThatIsAskedFor) {
  TrialQuestion asked = question("Wo ist der Herd?", {{1, 0}});
  asked.settings.language = "de";
  EXPECT_THAT(try_question(asked, home_with_stove()).prompts.front().text, HasSubstr("Herd"));
}

TEST(TrialQuestion, WhatIsNotUnderstoodOrWouldChangeTheHomeIsAnsweredByWhatCanBeAsked) {
  const auto home = home_with_stove();
  EXPECT_FALSE(try_question(question("bla bla bla"), home).prompts.empty());
  EXPECT_FALSE(try_question(question("teach a thing"), home).prompts.empty());
  EXPECT_FALSE(try_question(question(""), home).prompts.empty());
}

TEST(TrialQuestion, WhateverIsAskedSomethingIsSaid) {
  const auto home = home_with_stove();
  for (int i = 0; i <= static_cast<int>(service::Question::kIsItLight); ++i) {
    service::Ask ask;
    ask.question = static_cast<service::Question>(i);
    ask.subject = "stove";
    EXPECT_FALSE(try_ask(ask, question("", {{1, 0}}), home).prompts.empty())
        << to_string(ask.question);
    EXPECT_FALSE(try_ask(ask, question(""), home).prompts.empty()) << to_string(ask.question);
  }
}

TEST(TrialQuestion, TakeMeBackLeadsToTheSpotAsOnTheDevice) {
  const auto home = home_with_stove();
  EXPECT_EQ(try_question(question("take me back", {{0, 0}}), home).prompts.front().message_id,
            "spot.no_way_back");
  ViewedSpot& start = home->spots.emplace_back();
  start.thing.name = guide::kStartingPlace;
  start.thing.probability = 1;
  start.thing.position_plan = Eigen::Vector3d(3, 0, 0);
  const TrialAnswer led = try_question(question("take me back", {{0, 0}}), home);
  EXPECT_THAT(led.prompts.front().text, HasSubstr("starting place"));
  ASSERT_GE(led.way.size(), 2U);
  EXPECT_GT(led.way.back().x(), 2);
}

}  // namespace
}  // namespace roomwise::live
