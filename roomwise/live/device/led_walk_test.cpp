#include "roomwise/live/device/led_walk.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <utility>

#include "roomwise/guide/answers/spot_prompts.h"
#include "roomwise/guide/testing/drawn_floor.h"

namespace roomwise::live {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

constexpr double kTick_ms = 200;

std::shared_ptr<HomeView> home_with_microwave() {
  LiveMap map;  // with a floor of 6 x 4 m that is free
  map.floor.emplace(Eigen::Vector2d(-1, -2), 0.05,
                    image::Image<fusion::FloorCell>(120, 80, fusion::FloorCell::kFree));
  auto home = std::make_shared<HomeView>();
  home->map = std::make_shared<const LiveMap>(std::move(map));
  guide::KnownThing thing;
  thing.name = "microwave";
  thing.probability = 0.99;
  thing.position_plan = Eigen::Vector3d(4, 0, 1.2);
  thing.box_keyframe.size_m = {0.5, 0.5, 0.5};
  home->things = {thing};
  return home;
}

// A camera 1.3 m up, that looks along x.
FrameResult picture_at(const Eigen::Vector2d& place, double t_ms) {
  Eigen::Matrix3d plan_from_camera;
  plan_from_camera << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  FrameResult result;
  result.t_ms = t_ms;
  result.place.emplace();
  result.place->plan_from_camera = {Eigen::Quaterniond(plan_from_camera),
                                    {place.x(), place.y(), 1.3}};
  result.place->sigma_m = 0.03;
  return result;
}

service::Ask ask_for(const std::string& goal) {
  return {1, 1000, service::Question::kTakeMeTo, goal};
}

class LedWalkTest : public ::testing::Test {
 protected:
  [[nodiscard]] Situation at(const FrameResult& result) const {
    return {*home, &result, settings, result.t_ms};
  }
  std::vector<std::string> walk(LedWalk& led, double seconds, double speed_m_s) {
    std::vector<std::string> said;
    for (double passed_ms = 0; passed_ms < 1000 * seconds; passed_ms += kTick_ms) {
      t_ms += kTick_ms;
      x_m += speed_m_s * kTick_ms / 1000;
      for (const guide::Prompt& prompt : led.after(picture_at({x_m, 0}, t_ms), home)) {
        said.push_back(prompt.text);
      }
    }
    return said;
  }

  std::shared_ptr<HomeView> home = home_with_microwave();
  service::SpeakingSettings settings;
  double t_ms = 1000, x_m = 0;
};

TEST_F(LedWalkTest, LeadsAlongWithThePicturesThatCome) {
  const FrameResult first = picture_at({0, 0}, t_ms);
  const auto led = LedWalk::to(ask_for("microwave"), home, at(first));
  ASSERT_NE(led, nullptr);
  EXPECT_THAT(led->begin(at(first)).text, StartsWith("To the microwave: about 4"));
  EXPECT_THAT(walk(*led, 6, 0), ::testing::ElementsAre(StartsWith("Straight on, 3.5")));
  const auto said = walk(*led, 12, 0.5);
  EXPECT_THAT(said, ::testing::Contains("You are there: the microwave ahead, in reach."));
  EXPECT_THAT(said, ::testing::Contains("At chest height."));
  EXPECT_TRUE(led->is_over());
}

TEST_F(LedWalkTest, WhoIsLedHearsTheLanguageThatTheyChangeTo) {
  const FrameResult first = picture_at({0, 0}, t_ms);
  const auto led = LedWalk::to(ask_for("microwave"), home, at(first));
  ASSERT_NE(led, nullptr);
  EXPECT_EQ(led->begin(at(first)).language, "en");
  service::SpeakingSettings german = settings;
  german.language = "de";
  german.distances = service::Distances::kSteps;
  led->speak_by(german);
  const guide::Prompt left = led->hear(service::GuideWish::kHowFar, t_ms);
  EXPECT_EQ(left.language, "de");
  EXPECT_THAT(left.text, HasSubstr("Schritte"));
  EXPECT_EQ(led->watched().language, "de");
  // What was asked for in the language before is still known when the home changes.
  const auto changed = std::make_shared<HomeView>(*home);
  t_ms += kTick_ms;
  const auto said = led->after(picture_at({0, 0}, t_ms), changed);
  EXPECT_FALSE(led->is_over());
}

// Hall, kitchen and balcony side by side, with doors at x = 4 and x = 8.
TEST_F(LedWalkTest, LeadsToADoorByItsRooms) {
  LiveMap map;
  map.floor = guide::testing::three_rooms().grid();
  home->map = std::make_shared<const LiveMap>(std::move(map));
  home->layout = guide::testing::layout_along_x(*home->map->floor, {"hall", "kitchen", "balcony"});
  FrameResult result = picture_at({11, 3.45}, t_ms);
  const auto goal_x_m = [&](const std::string& in, const std::string& to, const std::string& here) {
    service::Ask door = ask_for("door");
    door.in_room = in;
    door.to_room = to;
    result.place->room = here;
    const auto led = LedWalk::to(door, home, at(result));
    if (!led) return 0.0;
    const guide::Plan plan = led->plan_from(at(result));
    EXPECT_EQ(plan.status, guide::PlanStatus::kComplete);
    return plan.touch_plan.x();
  };
  EXPECT_NEAR(goal_x_m("kitchen", "hall", "balcony"), 4.05, 0.15);
  EXPECT_NEAR(goal_x_m("hall", "kitchen", "balcony"), 4.05, 0.15);
  EXPECT_NEAR(goal_x_m("kitchen", "balcony", "balcony"), 8.05, 0.15);
  EXPECT_NEAR(goal_x_m("kitchen", "", "balcony"), 8.05, 0.15);
  EXPECT_EQ(goal_x_m("hall", "balcony", "balcony"), 0) << "there is none";
  result = picture_at({5, 3.45}, t_ms);
  EXPECT_NEAR(goal_x_m("kitchen", "", "kitchen"), 4.05, 0.15) << "the nearest";
}

// A hall of 6 m by 4 m, with a passage on each side of what is met.
TEST_F(LedWalkTest, WhatWasInTheWayBarsItForWhoAsksNextAndIsForgotten) {
  const FrameResult first = picture_at({0, 0}, t_ms);
  auto led = LedWalk::to(ask_for("microwave"), home, at(first));
  (void)led->begin(at(first));
  (void)walk(*led, 6, 0);
  const auto way_beside_m = [&](const LedWalk& one) {
    double farthest_m = 0;
    const FrameResult here = picture_at({0, 0}, t_ms);
    for (const auto& place : one.plan_from(at(here)).route) {
      farthest_m = std::max(farthest_m, std::abs(place.y()));
    }
    return farthest_m;
  };
  EXPECT_LT(way_beside_m(*led), 0.2);
  t_ms += kTick_ms;
  FrameResult barred = picture_at({0.3, 0}, t_ms);
  for (double y = -0.2; y < 0.25; y += 0.1) barred.obstacles.emplace_back(1.2, y);
  const auto said = led->after(barred, home);
  ASSERT_FALSE(said.empty());
  EXPECT_EQ(said.front().message_id, "guide.stop_obstacle_ahead");
  EXPECT_GT(way_beside_m(*led), 0.3) << "around it";
  const FrameResult back = picture_at({0, 0}, t_ms + 1000);
  const auto next = LedWalk::to(ask_for("microwave"), home, at(back), led.get());
  EXPECT_GT(way_beside_m(*next), 0.3);
  ASSERT_NE(next->floor_on(*home), nullptr);
  EXPECT_EQ(next->floor_on(*home)->at(Eigen::Vector2d(1.2, 0)), fusion::FloorCell::kOccupied);
  t_ms += 1000 * guide::kBarred_s;
  const FrameResult later = picture_at({0, 0}, t_ms);
  (void)next->after(later, home);
  EXPECT_LT(way_beside_m(*next), 0.2) << "it may have gone";
  HomeView anew = *home;
  anew.map = std::make_shared<const LiveMap>();
  EXPECT_EQ(next->floor_on(anew), nullptr);
}

TEST_F(LedWalkTest, TellsWhatTheGoalLiesOn) {
  guide::KnownThing& shelf = home->things.emplace_back(home->things[0]);
  shelf.name = "shelf";
  shelf.position_plan->z() = 0.45;
  shelf.box_keyframe.size_m = {0.8, 0.8, 0.9};
  const FrameResult first = picture_at({0, 0}, t_ms);
  const auto led = LedWalk::to(ask_for("microwave"), home, at(first));
  (void)led->begin(at(first));
  (void)walk(*led, 6, 0);
  const auto said = walk(*led, 20, 0.5);
  EXPECT_THAT(said, ::testing::IsSupersetOf({"On the shelf.", "At chest height."}));
  shelf.probability = 0.2;
  EXPECT_EQ(guide::Goal::of(home->things[0], {}, home->things).on, "") << "it may be gone";
}

TEST_F(LedWalkTest, NearTheGoalItTellsWhereItIsByTheNewestPicture) {
  const FrameResult first = picture_at({0, 0}, t_ms);
  const auto led = LedWalk::to(ask_for("microwave"), home, at(first));
  (void)led->begin(at(first));
  (void)walk(*led, 6, 0);
  EXPECT_FALSE(led->goal_bearing(t_ms)) << "3.75 m away";
  (void)walk(*led, 5, 0.5);
  const auto bearing = led->goal_bearing(t_ms);
  ASSERT_TRUE(bearing);
  EXPECT_EQ(bearing->t_ms, t_ms);
  EXPECT_EQ(bearing->valid_until_t_ms, t_ms + 1000);
  EXPECT_NEAR(bearing->distance_m, 3.75 - x_m, 0.05);
  EXPECT_NEAR(bearing->bearing_degrees, 0, 5);
  FrameResult unsure = picture_at({x_m, 0}, t_ms + 200);
  unsure.place->sigma_m = 0.4;
  (void)led->after(unsure, home);
  EXPECT_FALSE(led->goal_bearing(t_ms));
  FrameResult blind = picture_at({x_m, 0}, t_ms + 400);
  blind.place.reset();
  (void)led->after(blind, home);
  EXPECT_FALSE(led->goal_bearing(t_ms));
  t_ms += 400;
  (void)walk(*led, 5, 0.5);
  EXPECT_TRUE(led->is_over());
  EXPECT_FALSE(led->goal_bearing(t_ms));
}

TEST_F(LedWalkTest, AGoalThatWasSeenLongAgoIsProbable) {
  const CalendarTime seen{2023, 11, 26, 9};
  home->things[0].seen = seen;
  const FrameResult first = picture_at({0, 0}, t_ms);
  const auto confidence_on = [&](const CalendarTime& today) {
    Situation situation = at(first);
    situation.today = today;
    return LedWalk::to(ask_for("microwave"), home, situation)->begin(situation).confidence;
  };
  EXPECT_EQ(confidence_on(seen), guide::Confidence::kSure);
  EXPECT_EQ(confidence_on({2026, 11, 26, 9}), guide::Confidence::kProbable);
}

TEST_F(LedWalkTest, HearsWhatIsWished) {
  const FrameResult first = picture_at({0, 0}, t_ms);
  const auto led = LedWalk::to(ask_for("microwave"), home, at(first));
  (void)led->begin(at(first));
  EXPECT_THAT(led->hear(service::GuideWish::kHowFar, t_ms).text, HasSubstr("to the microwave."));
  EXPECT_EQ(led->hear(service::GuideWish::kPause, t_ms).text, "Paused.");
  EXPECT_THAT(walk(*led, 10, 0.1), IsEmpty());
  EXPECT_EQ(led->hear(service::GuideWish::kResume, t_ms).text, "Going on.");
  EXPECT_THAT(led->repeat(t_ms).text, StartsWith("Straight on"));
  EXPECT_EQ(led->hear(service::GuideWish::kEnd, t_ms).text, "Guidance has ended.");
  EXPECT_TRUE(led->is_over());
}

TEST_F(LedWalkTest, WhoIsNotSeenIsAnsweredAndLedOnceTheyAre) {
  const Situation blind{*home, nullptr, settings, t_ms};
  const auto led = LedWalk::to(ask_for("microwave"), home, blind);
  ASSERT_NE(led, nullptr);
  EXPECT_EQ(led->begin(blind).text, "I do not know where you stand. Turn slowly.");
  EXPECT_THAT(walk(*led, 12, 0),
              ::testing::ElementsAre("Stop. I know again where you are.",
                                     StartsWith("To the microwave"), StartsWith("Straight on")));
}

// Two steps and a body's radius are more than what "Obstacle ahead." is told of.
TEST_F(LedWalkTest, NoStepIsToldUnseenTowardsWhatDepthShowsBeyondTheNextOne) {
  const FrameResult first = picture_at({3, 0}, t_ms);
  home->things[0].position_plan->x() = 0;
  for (const auto& [seen_ahead_m, is_told] : {std::pair(1.1, false), std::pair(1.5, true)}) {
    const auto led = LedWalk::to(ask_for("microwave"), home, at(first));
    (void)led->begin(at(first));
    x_m = 3;
    EXPECT_THAT(walk(*led, 6, 0), ::testing::Contains("Turn around."));
    std::vector<std::string> said;
    for (int picture = 0; picture < 60; ++picture) {
      FrameResult unseen;
      unseen.t_ms = t_ms += kTick_ms;
      unseen.seen_ahead_m = seen_ahead_m;
      for (const guide::Prompt& prompt : led->after(unseen, home)) said.push_back(prompt.text);
    }
    EXPECT_EQ(std::ranges::count_if(
                  said, [](const std::string& text) { return text.starts_with("Straight on"); }),
              is_told ? 1 : 0);
  }
}

TEST_F(LedWalkTest, LeadsToAPlaceThatSomebodyMarked) {
  ViewedSpot& spot = home->spots.emplace_back();
  spot.stored.name = spot.thing.name = "my microwave";  // before the home's own
  spot.thing.position_plan = Eigen::Vector3d(2, 0, 1.3);
  const FrameResult first = picture_at({0, 0}, t_ms);
  const auto led = LedWalk::to(ask_for("my microwave"), home, at(first));
  ASSERT_TRUE(led);
  EXPECT_THAT(led->begin(at(first)).text, StartsWith("To my microwave: about 2 metres"));
  for (int i = 0; i < 20 && !led->is_over(); ++i) (void)walk(*led, 1, x_m < 1.9 ? 0.5 : 0);
  EXPECT_TRUE(led->is_over());
  EXPECT_NEAR(x_m, 2, 0.4);
}

TEST_F(LedWalkTest, LeadsToTheWayOutByItsGoalAndByAnyNameOfIt) {
  service::Ask out = ask_for("");
  out.is_way_out = true;
  const FrameResult first = picture_at({0, 0}, t_ms);
  EXPECT_EQ(LedWalk::to(out, home, at(first)), nullptr) << "nobody added one";
  for (const char* name : {"way out", "front door"}) {
    home->things[0].name = name;
    EXPECT_THAT(LedWalk::to(out, home, at(first))->begin(at(first)).text,
                StartsWith("To the way out: about 4"))
        << name;
    EXPECT_NE(LedWalk::to(ask_for("exit"), home, at(first)), nullptr) << name;
  }
  settings.language = "de";
  EXPECT_EQ(LedWalk::to(out, home, at(first)), nullptr) << "no German word";
  home->things[0].name = "Haustür";
  EXPECT_THAT(LedWalk::to(out, home, at(first))->begin(at(first)).text, HasSubstr("Ausgang"));
}

TEST_F(LedWalkTest, AWayOutThatSomebodyMarkedComesFirst) {
  home->things[0].name = "way out";
  ViewedSpot& spot = home->spots.emplace_back();
  spot.stored.name = spot.thing.name = "exit";
  spot.thing.position_plan = Eigen::Vector3d(2, 0, 1.3);
  service::Ask out = ask_for("");
  out.is_way_out = true;
  const FrameResult first = picture_at({0, 0}, t_ms);
  const auto led = LedWalk::to(out, home, at(first));
  ASSERT_NE(led, nullptr);
  EXPECT_THAT(led->begin(at(first)).text, HasSubstr("about 2 metres"));
}

TEST(WayBack, IsWhereSomebodyAskedToBeRememberedElseWhereTheySetOut) {
  HomeView home;
  constexpr std::int64_t kNow_s = 1'000'000, kHour_s = 3600;
  EXPECT_EQ(way_back(home, kNow_s), std::nullopt);
  home.spots.emplace_back().thing.name = guide::kRememberedPlace;
  home.spots.back().stored.marked_s = kNow_s - 24 * kHour_s;
  EXPECT_EQ(way_back(home, kNow_s), guide::kRememberedPlace);
  home.spots.emplace_back().thing.name = guide::kStartingPlace;
  EXPECT_EQ(way_back(home, kNow_s), guide::kStartingPlace) << "yesterday's is seldom meant";
  home.spots.front().stored.marked_s = kNow_s - kHour_s;
  EXPECT_EQ(way_back(home, kNow_s), guide::kRememberedPlace);
}

TEST_F(LedWalkTest, WhatTheHomeDoesNotKnowIsNoGoal) {
  const FrameResult first = picture_at({0, 0}, t_ms);
  EXPECT_EQ(LedWalk::to(ask_for("piano"), home, at(first)), nullptr);
  EXPECT_EQ(LedWalk::to(ask_for("door"), home, at(first)), nullptr) << "no layout, no doors";
}

TEST_F(LedWalkTest, BeginsAnewOnANewMap) {
  const FrameResult first = picture_at({0, 0}, t_ms);
  const auto led = LedWalk::to(ask_for("microwave"), home, at(first));
  (void)led->begin(at(first));
  (void)walk(*led, 6, 0);
  home = home_with_microwave();
  EXPECT_THAT(walk(*led, 1, 0), ::testing::ElementsAre(StartsWith("To the microwave")));
}

TEST_F(LedWalkTest, WhoPausedIsLedOnANewMapOnlyWhenTheyGoOn) {
  const FrameResult first = picture_at({0, 0}, t_ms);
  const auto led = LedWalk::to(ask_for("microwave"), home, at(first));
  (void)led->begin(at(first));
  (void)walk(*led, 6, 0);
  (void)led->hear(service::GuideWish::kPause, t_ms);
  home = home_with_microwave();
  EXPECT_THAT(walk(*led, 10, 0), IsEmpty());
  EXPECT_EQ(led->hear(service::GuideWish::kResume, t_ms).text, "Going on.");
  EXPECT_THAT(walk(*led, 3, 0), ::testing::ElementsAre(StartsWith("To the microwave")));
}

TEST_F(LedWalkTest, EndsWithAWordWhereANewMapLacksTheGoal) {
  const FrameResult first = picture_at({0, 0}, t_ms);
  const auto led = LedWalk::to(ask_for("microwave"), home, at(first));
  (void)led->begin(at(first));
  (void)walk(*led, 6, 0);
  home = home_with_microwave();
  home->things.clear();
  const auto map = std::exchange(home->map, nullptr);
  EXPECT_THAT(walk(*led, 1, 0), IsEmpty()) << "it is not ready yet";
  EXPECT_FALSE(led->is_over());
  home->map = map;
  EXPECT_THAT(walk(*led, 10, 0),
              ::testing::ElementsAre("Stop. I no longer know the microwave. Guidance has ended."));
  EXPECT_TRUE(led->is_over());
}

// The map is the same, as where a helper changes what stands on it.
TEST_F(LedWalkTest, StopsWhoIsLedToWhatAHelperTookAway) {
  for (const char* language : {"en", "de", "es", "fr"}) {
    SCOPED_TRACE(language);
    settings.language = language;
    home = home_with_microwave();
    x_m = 0;
    const FrameResult first = picture_at({0, 0}, t_ms);
    const auto led = LedWalk::to(ask_for("microwave"), home, at(first));
    (void)led->begin(at(first));
    (void)walk(*led, 6, 0);
    home = std::make_shared<HomeView>(*home);
    EXPECT_THAT(walk(*led, 4, 0.2), Not(::testing::Contains(StartsWith("Stop. I no")))) << "there";
    EXPECT_FALSE(led->is_over());
    home = std::make_shared<HomeView>(*home);
    home->things.clear();
    const auto said = led->after(picture_at({x_m, 0}, t_ms += kTick_ms), home);
    ASSERT_THAT(said, ::testing::SizeIs(1));
    EXPECT_EQ(said[0].message_id, "guide.ended_unknown");
    EXPECT_EQ(said[0].sound, guide::Sound::kAlert);
    EXPECT_TRUE(led->is_over());
    EXPECT_THAT(walk(*led, 10, 0), IsEmpty());
  }
}

TEST_F(LedWalkTest, LeadsToWhereAHelperMovedTheGoal) {
  const FrameResult first = picture_at({0, 0}, t_ms);
  const auto led = LedWalk::to(ask_for("microwave"), home, at(first));
  (void)led->begin(at(first));
  (void)walk(*led, 6, 0);
  home = std::make_shared<HomeView>(*home);
  home->things[0].position_plan = Eigen::Vector3d(2.5, 1.2, 1.2);
  const auto said = walk(*led, 6, 0);
  ASSERT_FALSE(said.empty());
  EXPECT_THAT(said.front(), StartsWith("To the microwave: about 2"));
  const FrameResult here = picture_at({x_m, 0}, t_ms);
  EXPECT_NEAR(led->plan_from(at(here)).touch_plan.y(), 1, 0.3);
}

// Whatever else changes, and where another one stands nearer by now.
TEST_F(LedWalkTest, LeadsOnToTheSameThingWhileItStandsThere) {
  const FrameResult first = picture_at({0, 0}, t_ms);
  const auto led = LedWalk::to(ask_for("microwave"), home, at(first));
  (void)led->begin(at(first));
  (void)walk(*led, 6, 0);
  home = std::make_shared<HomeView>(*home);
  home->things.push_back(home->things[0]);
  home->things[1].position_plan = Eigen::Vector3d(1, 1, 1.2);
  EXPECT_THAT(walk(*led, 4, 0), Not(::testing::Contains(StartsWith("To the microwave"))));
  const FrameResult here = picture_at({x_m, 0}, t_ms);
  EXPECT_GT(led->plan_from(at(here)).touch_plan.x(), 3);
  home = std::make_shared<HomeView>(*home);
  home->things.erase(home->things.begin());
  EXPECT_THAT(walk(*led, 1, 0), ::testing::ElementsAre(StartsWith("To the microwave: about")));
  EXPECT_LT(led->plan_from(at(here)).touch_plan.x(), 2) << "of that name there is another";
}

}  // namespace
}  // namespace roomwise::live
