#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "roomwise/guide/answers/route_prompts.h"
#include "roomwise/guide/led/guidance.h"
#include "roomwise/guide/questions/home_prompts.h"
#include "roomwise/guide/testing/test_times.h"
#include "roomwise/guide/way/way_phrases.h"

namespace roomwise::guide {
namespace {

using Eigen::Vector2d;
using fusion::FloorCell;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

// A hall of 2 m x 6 m below, stairs of 14 steps along x from (6, 1) up to (9.5, 1), and a hall of
// 2 m x 6 m above, which the plan draws 20 m farther along x. A rail on the right of who climbs.
class StairsTest : public ::testing::Test {
 protected:
  StairsTest()
      : storeys_(make_storeys()),
        grid_(make_grid()),
        layout_(make_layout(storeys_.stairs()[0].below_plan, storeys_.stairs()[0].above_plan)) {}

  static fusion::Storeys make_storeys() {
    fusion::Storey upper;
    upper.floor_m = 2.5;
    upper.plan_from_gravity = {20, 0};
    upper.plan_from_x_m = 18;
    fusion::Staircase stairs;
    stairs.below_plan = {5.5, 1};
    stairs.above_plan = {30, 1};
    stairs.foot_gravity = {6, 1};
    stairs.top_gravity = {9.5, 1};
    stairs.run_m = 3.5;
    stairs.height_m = 2.5;
    stairs.steps = 14;
    stairs.width_m = 1;
    stairs.has_right_rail = true;
    return fusion::Storeys({fusion::Storey{}, upper}, {stairs});
  }
  static fusion::FloorGrid make_grid() {
    constexpr double kCell_m = 0.1;
    image::Image<FloorCell> cells(360, 20, FloorCell::kUnknown);
    for (int row = 0; row < 20; ++row) {
      for (int column = 0; column < 360; ++column) {
        const bool is_free = column < 60 || column >= 295;
        const bool is_barred = (column >= 60 && column < 95) || (column >= 255 && column < 295);
        if (is_free) cells.at(column, row) = FloorCell::kFree;
        if (is_barred) cells.at(column, row) = FloorCell::kOccupied;
      }
    }
    return {Vector2d::Zero(), kCell_m, std::move(cells)};
  }
  [[nodiscard]] rooms::RoomLayout make_layout(const Vector2d& below_plan,
                                              const Vector2d& above_plan) const {
    rooms::WalkedPath below, above;
    for (double x = 0.5; x < 5.5; x += 0.1) below.push_back({{x, 1}, "hall"});
    for (double x = 30; x < 35; x += 0.1) above.push_back({{x, 1}, "landing"});
    rooms::RoomLayout layout = rooms::RoomLayout::make(grid_, std::vector{below, above}).value();
    layout.add_stairs(below_plan, above_plan);
    return layout;
  }
  [[nodiscard]] HomeMap map() const {
    return {&grid_, &layout_, layout_.doorways(), {}, &storeys_};
  }
  [[nodiscard]] Goal room(const std::string& name) const {
    return Goal::of(*std::ranges::find(layout_.rooms(), name, &rooms::RoomExtent::name));
  }
  [[nodiscard]] static KnownThing standing(const std::string& name, const Vector2d& place,
                                           const std::string& room) {
    KnownThing thing;
    thing.name = name;
    thing.probability = 0.95;
    thing.box_keyframe.size_m = {0.4, 0.4, 1};
    thing.position_plan = Eigen::Vector3d(place.x(), place.y(), 0.5);
    thing.room = room;
    return thing;
  }
  [[nodiscard]] static std::vector<std::string> texts(const std::vector<Prompt>& prompts) {
    std::vector<std::string> texts;
    for (const Prompt& prompt : prompts) texts.push_back(prompt.text);
    return texts;
  }
  void lead_to(const std::string& name, const Vector2d& from, double heading_rad) {
    place_ = from;
    heading_rad_ = heading_rad;
    guidance_.emplace(map(), room(name), wording_);
  }
  std::vector<std::string> hear(double seconds, const Vector2d& speed_m_s = Vector2d::Zero()) {
    std::vector<std::string> said;
    const auto ticks = static_cast<int>(std::lround(seconds * kSecond / kTick));
    for (int i = 0; i < ticks; ++i) {
      now_ns_ += kTick;
      place_ += kTick * 1e-9 * speed_m_s;
      Walker walker{now_ns_};
      if (is_seen_) {
        walker.pose = Pose{place_, heading_rad_, 0.02};
        walker.pose_ns = now_ns_;
      }
      if (auto prompt = guidance_->update(walker)) said.push_back(prompt->text);
    }
    return said;
  }

  const MessageCatalogue catalogue_ = MessageCatalogue::built_in();
  Wording wording_{&catalogue_, {"en", DistanceUnit::kSteps, 0.5}};
  fusion::Storeys storeys_;
  fusion::FloorGrid grid_;
  rooms::RoomLayout layout_;
  std::optional<Guidance> guidance_;
  TimestampNs now_ns_ = kNow;
  Vector2d place_ = Vector2d::Zero();
  double heading_rad_ = 0;
  bool is_seen_ = true;
};

TEST_F(StairsTest, JoinTheRoomsInWhichTheyBeginAndEnd) {
  ASSERT_EQ(layout_.doorways().size(), 1U);
  EXPECT_TRUE(layout_.doorways()[0].is_stairs);
  EXPECT_THAT(layout_.neighbors("hall"), ElementsAre("landing"));
  EXPECT_FALSE(layout_.doorways()[0].is_door()) << "nobody is told of a door there";
}

TEST_F(StairsTest, AreALegOfTheWay) {
  const Plan plan = plan_way(map(), {.pose = Pose{{1, 1}, 0, 0.02}}, room("landing"));
  ASSERT_EQ(plan.status, PlanStatus::kComplete);
  EXPECT_LT(length_m(plan.route, storeys_.stairs()), 11);
  const auto legs = legs_of(plan.route, {}, storeys_.stairs());
  ASSERT_GE(legs.size(), 2U);
  EXPECT_FALSE(legs[0].stairs);
  ASSERT_TRUE(legs[1].stairs);
  EXPECT_TRUE(legs[1].stairs->is_up);
}

TEST_F(StairsTest, AreToldInTheListOfAWay) {
  const Pose pose{{1, 1}, 0, 0.02};
  const Plan plan = plan_way(map(), {.pose = pose}, room("landing"));
  std::vector<std::string> said;
  for (const Prompt& prompt : route_prompts(plan.route, pose, {Noun::Kind::kRoom, "landing"}, {},
                                            wording_, 0, storeys_.stairs())) {
    said.push_back(prompt.text);
  }
  EXPECT_THAT(said, Contains("Straight on, then 9 steps to the stairs up."));
  EXPECT_THAT(said, Contains("Stairs up, 14 steps, rail on the right."));
}

TEST_F(StairsTest, WhereTheyTurnTheListGoesOnFromHowOneFacesAtTheirEnd) {
  fusion::Staircase turning = storeys_.stairs()[0];
  turning.end_rad = std::numbers::pi / 2;
  const std::vector<fusion::Staircase> flights{turning};
  const auto after_them = [&](const Route& route, double heading_rad) {
    return texts(route_prompts(route, {route.front(), heading_rad, 0.02},
                               {Noun::Kind::kRoom, "hall"}, {}, wording_, 0, flights))
        .back();
  };
  // Down they come as who went up would have begun, turned about.
  EXPECT_THAT(after_them({turning.above_plan, turning.below_plan, {1, 1}}, -std::numbers::pi / 2),
              HasSubstr("Straight on"));
  EXPECT_THAT(after_them({turning.below_plan, turning.above_plan, {34, 1}}, 0),
              HasSubstr("Turn right"));
}

TEST_F(StairsTest, AreStoppedBeforeAndToldWithStepsAndRailAndThenThatOneIsUpstairs) {
  lead_to("landing", {2.5, 1}, 0);
  hear(9);
  ASSERT_EQ(guidance_->state(), Guidance::State::kWalking);
  EXPECT_THAT(hear(4, {0.5, 0}), Contains("In 2 steps: stairs up."));
  EXPECT_THAT(hear(2, {0.5, 0}), Contains("Stop."));
  EXPECT_THAT(hear(4), Contains("Stairs up, 14 steps, rail on the right."));
  EXPECT_EQ(guidance_->state(), Guidance::State::kStairs);
  place_ = {5.5, 1};
  EXPECT_THAT(hear(4, {0.5, 0}), IsEmpty()) << "nothing is said on the steps";
  place_.x() += 20;  // the camera comes over the upper floor
  const auto said = hear(6, {0.5, 0});
  EXPECT_THAT(said, Contains("You are upstairs."));
}

TEST_F(StairsTest, AreToldAgainToWhoStandsBeforeThemAndNotToWhoRestsOnThem) {
  for (const double x : {5.2, 7.5, 28.0}) {  // the last one over the upper floor
    lead_to("landing", {5.2, 1}, 0);
    hear(7);
    ASSERT_EQ(guidance_->state(), Guidance::State::kStairs);
    place_.x() = x;
    hear(4);
    EXPECT_EQ(hear(12).empty(), x > 6) << x;
  }
}

TEST_F(StairsTest, AreToldDownwardsWithTheRailOnTheOtherSide) {
  lead_to("hall", {32, 1}, std::numbers::pi);
  hear(9);
  EXPECT_THAT(hear(4, {-0.5, 0}), Contains("Stop."));
  EXPECT_THAT(hear(4), Contains("Stairs down, 14 steps, rail on the left."));
  place_ = {28, 1};
  hear(2, {-0.5, 0});
  place_.x() -= 20;
  EXPECT_THAT(hear(6, {-0.5, 0}), Contains("You are downstairs."));
}

TEST_F(StairsTest, WhoTurnsBackBeforeThemIsLedAnew) {
  lead_to("landing", {5.2, 1}, 0);
  hear(12);
  ASSERT_EQ(guidance_->state(), Guidance::State::kStairs);
  hear(6, {-0.5, 0});
  EXPECT_NE(guidance_->state(), Guidance::State::kStairs);
}

// Nobody checks which way they face then.
TEST_F(StairsTest, NoStepTowardsThemIsToldToWhoIsNotSeen) {
  lead_to("landing", {4.5, 1}, std::numbers::pi);
  hear(9);
  ASSERT_EQ(guidance_->state(), Guidance::State::kTurning);
  is_seen_ = false;
  EXPECT_THAT(hear(12), ElementsAre("I lost where you are. Stop and turn slowly."));
}

// Nobody is to turn about on a step.
TEST_F(StairsTest, WhoIsNotSeenOnTheStepsIsToWaitAndHearsWhenTheyAreSeenAgain) {
  lead_to("landing", {5.2, 1}, 0);
  hear(12);
  ASSERT_EQ(guidance_->state(), Guidance::State::kStairs);
  hear(1, {0.5, 0});
  is_seen_ = false;
  const auto lost = hear(40);
  ASSERT_FALSE(lost.empty());
  for (const std::string& text : lost) EXPECT_EQ(text, "I lost where you are. Stop and wait.");
  is_seen_ = true;
  EXPECT_THAT(hear(2), Contains("Stop. I know again where you are."));
}

// On the plan storeys lie side by side.
TEST_F(StairsTest, ARoomOnAnotherStoreyHasNoDirection) {
  const UserLocation below{Pose{{1, 1}, 0, 0.02}, "hall"};
  EXPECT_THAT(texts(room_way_prompts("landing", map(), below, wording_, {})),
              ElementsAre("The landing is the next room."));
  const UserLocation somewhere{below.pose};
  EXPECT_THAT(texts(room_way_prompts("landing", map(), somewhere, wording_, {})),
              ElementsAre("I know no safe way there."));
  EXPECT_THAT(texts(room_way_prompts("hall", map(), somewhere, wording_, {})),
              ElementsAre(HasSubstr("o'clock")));
}

TEST_F(StairsTest, NobodyFacesWhatStandsOnAnotherStorey) {
  const std::vector<KnownThing> things{standing("lamp", {32, 1}, "landing")};
  HomeMap home = map();
  home.things = things;
  EXPECT_THAT(texts(facing_prompts(home, {.pose = Pose{{1, 1}, 0, 0.02}}, wording_, {})),
              ElementsAre("I know of nothing that you face."));
  EXPECT_THAT(texts(facing_prompts(home, {.pose = Pose{{31, 1}, 0, 0.02}}, wording_, {})),
              ElementsAre(HasSubstr("face the lamp")));
}

TEST_F(StairsTest, TheThingsOfAnUpperRoomAreToldClockwiseFromWhereTheStairsEnd) {
  const Vector2d middle = room("landing").outline->middle_plan;
  // Of who comes up the stairs, left and right of the middle.
  const std::vector<KnownThing> things{standing("chair", middle - Vector2d(0, 0.5), "landing"),
                                       standing("lamp", middle + Vector2d(0, 0.5), "landing")};
  HomeMap home = map();
  home.things = things;
  const auto told = [&] { return texts(describe_prompts("landing", home, {}, wording_, {})); };
  EXPECT_THAT(told(), Contains("Clockwise from the hall: lamp and chair."));
  rooms::RoomLayout other = make_layout(storeys_.stairs()[0].below_plan, {35.5, 1});
  home.layout = &other;
  home.doorways = other.doorways();
  EXPECT_THAT(told(), Contains("Clockwise from the hall: chair and lamp."));
}

// Barred, or where no floor was seen at their end.
TEST_F(StairsTest, WhoCannotTakeThemIsLedToWhereTheyAre) {
  const fusion::Storeys barred(storeys_.all());
  const rooms::RoomLayout layout = make_layout(storeys_.stairs()[0].below_plan, {35.5, 1});
  const HomeMap home{&grid_, &layout, layout.doorways(), {}, &barred};
  const Plan plan = plan_way(home, {.pose = Pose{{32, 1}, 0, 0.02}}, room("hall"));
  ASSERT_EQ(plan.status, PlanStatus::kPartial);
  EXPECT_GT(plan.route.back().x(), 35);
}

TEST_F(StairsTest, WhatIsLeftToAGoalOnAnotherStoreyIsToldByItsRoom) {
  const fusion::Storeys barred(storeys_.all());
  place_ = {5.5, 1};
  guidance_.emplace(HomeMap{&grid_, &layout_, {}, {}, &barred},
                    Goal::of(standing("lamp", {32, 1}, "landing"), {}), wording_);
  const auto said = hear(20);
  EXPECT_THAT(said, Contains("I know the way no further."));
  EXPECT_THAT(said, Contains("The lamp is in the landing."));
  EXPECT_THAT(said, Not(Contains(HasSubstr("o'clock"))));
}

TEST_F(StairsTest, AreToldInEveryLanguageWithTheRightPlural) {
  StairsOnWay way{storeys_.stairs()[0], true};
  const auto in = [&](const char* language) {
    wording_.style.language = language;
    const Phrase phrase = stairs_phrase(way, wording_.phrases());
    return wording_.phrases().text(phrase.message_id, phrase.values);
  };
  EXPECT_EQ(in("de"), "Treppe hinauf, 14 Stufen, Geländer rechts.");
  EXPECT_EQ(in("es"), "Escalera de subida, 14 escalones, barandilla a la derecha.");
  EXPECT_EQ(in("fr"), "Escalier qui monte, 14 marches, rampe à droite.");
  way.stairs.steps = 1;
  way.stairs.has_right_rail = false;
  EXPECT_EQ(in("en"), "Stairs up, 1 step.");
  EXPECT_EQ(in("de"), "Treppe hinauf, eine Stufe.");
  EXPECT_EQ(in("fr"), "Escalier qui monte, une marche.");
  way.stairs.steps = 0;
  EXPECT_EQ(in("en"), "Stairs up.") << "where the steps could not be counted";
}

}  // namespace
}  // namespace roomwise::guide
