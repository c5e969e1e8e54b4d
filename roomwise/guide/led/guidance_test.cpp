#include "roomwise/guide/led/guidance.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/guide/led/led_phrases.h"
#include "roomwise/guide/testing/drawn_floor.h"
#include "roomwise/guide/testing/test_times.h"
#include "roomwise/guide/way/legs.h"
#include "roomwise/guide/way/way_phrases.h"

namespace roomwise::guide {
namespace {

using Eigen::Vector2d;
using fusion::FloorCell;
using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;
using State = Guidance::State;

constexpr double kPi = std::numbers::pi;

// Somebody who is moved by hand through two rooms (drawn_floor.h) on a simulated clock, and hears
// what is said. Steps of half a metre.
class GuidanceTest : public ::testing::Test {
 protected:
  GuidanceTest()
      : grid_(testing::two_rooms().grid()), layout_(testing::layout_of_two_rooms(grid_)) {}

  void lead_to(Goal goal, const Vector2d& from, double heading_rad) {
    place_ = from;
    heading_rad_ = heading_rad;
    guidance_.emplace(map(), std::move(goal), wording_);
  }
  [[nodiscard]] HomeMap map() const {
    if (!has_rooms_) return {&grid_, nullptr, {}, things_};
    return {&grid_, &layout_, layout_.doorways(), things_};
  }
  [[nodiscard]] static Goal bed_at(const Vector2d& middle, const std::string& room) {
    Goal goal;
    goal.noun = {Noun::Kind::kThing, "bed"};
    goal.outline = Outline{middle, {1, 1}};
    goal.room = room;
    goal.height_m = 0.5;
    return goal;
  }
  [[nodiscard]] Goal room(const std::string& name) const {
    return Goal::of(*std::ranges::find(layout_.rooms(), name, &rooms::RoomExtent::name));
  }

  // What is said until so many seconds have passed while they walk and turn evenly.
  std::vector<Prompt> go(double seconds, double speed_m_s = 0, double turning_rad_s = 0) {
    std::vector<Prompt> said;
    const auto ticks = static_cast<int>(std::lround(seconds * kSecond / kTick));
    for (int i = 0; i < ticks; ++i) {
      now_ns_ += kTick;
      const double dt = kTick * 1e-9;
      heading_rad_ += turning_rad_s * dt;
      place_ += speed_m_s * dt * Vector2d(std::cos(heading_rad_), std::sin(heading_rad_));
      if (auto prompt = guidance_->update(walker())) said.push_back(*prompt);
    }
    return said;
  }
  [[nodiscard]] Walker walker() const {
    Walker walker{now_ns_};
    if (is_seen_) {
      walker.pose = Pose{place_, heading_rad_, sigma_m_};
      walker.pose_ns = now_ns_;
    }
    walker.room = room_;
    walker.obstacle_m = depth_m_;
    walker.has_depth = has_depth_;
    for (const double left_m : {-0.2, -0.1, 0.0, 0.1, 0.2}) {
      if (is_seen_ && obstacle_m_) {
        walker.obstacles.push_back(walker.pose->place_of({*obstacle_m_, left_m}));
      }
    }
    if (sees_floor_) {
      for (double x = 0.05; x < 14; x += 0.1) {
        for (double y = 0.05; y < 4; y += 0.1) {
          const bool is_near = (Vector2d(x, y) - place_).norm() < 1.5;
          if (is_near && grid_.at(Vector2d(x, y)) == FloorCell::kOccupied) {
            walker.obstacles.emplace_back(x, y);
          }
        }
      }
    }
    return walker;
  }
  [[nodiscard]] static std::vector<std::string> texts(const std::vector<Prompt>& prompts) {
    std::vector<std::string> texts;
    for (const Prompt& prompt : prompts) texts.push_back(prompt.text);
    return texts;
  }
  std::vector<std::string> hear(double seconds, double speed_m_s = 0, double turning_rad_s = 0) {
    return texts(go(seconds, speed_m_s, turning_rad_s));
  }
  [[nodiscard]] std::string ask(GuidanceRequest request) {
    return guidance_->request(request, now_ns_).text;
  }
  void walk_until_barred_unseen() {
    lead_to(bed_at({3.3, 3.3}, "bedroom"), {0.6, 0.6}, kPi / 4);
    (void)hear(8);
    (void)hear(1, 0.6);
    is_seen_ = false;
    (void)hear(2);
    EXPECT_EQ(ask(GuidanceRequest::kBlocked), "I lost where you are. Stop and wait.");
  }

  const MessageCatalogue catalogue_ = MessageCatalogue::built_in();
  const Wording wording_{&catalogue_, {"en", DistanceUnit::kSteps, 0.5}};
  fusion::FloorGrid grid_;
  rooms::RoomLayout layout_;
  std::vector<KnownThing> things_;
  std::optional<Guidance> guidance_;
  TimestampNs now_ns_ = kNow;
  Vector2d place_ = Vector2d::Zero();
  double heading_rad_ = 0, sigma_m_ = 0.02;
  bool is_seen_ = true, has_depth_ = true, has_rooms_ = true;
  std::optional<std::string> room_;
  std::optional<double> obstacle_m_;  // ahead of them, as broad as a body
  std::optional<double> depth_m_;     // straight ahead, wherever they are
  bool sees_floor_ = false;           // what stands about them, as it is on the map
};

TEST_F(GuidanceTest, BeginsByWhereOneStandsAndThenOneActionAtATime) {
  lead_to(room("kitchen"), {1, 3.45}, kPi);
  EXPECT_THAT(hear(9), ElementsAre("To the kitchen: about 7 steps.", "The door is behind you.",
                                   "Turn around."));
  EXPECT_EQ(guidance_->state(), State::kTurning);
  EXPECT_THAT(hear(2, 0, kPi / 2), IsEmpty()) << "while one turns";
  EXPECT_THAT(hear(2), ElementsAre("Straight on, 6 steps to the door."));
  EXPECT_EQ(guidance_->state(), State::kWalking);
}

TEST_F(GuidanceTest, WhereNoDoorIsNextItBeginsWithWhatIsNearThem) {
  const auto stands = [&](const char* name, const Vector2d& middle) {
    KnownThing& thing = things_.emplace_back();
    thing.name = name;
    thing.probability = 0.95;
    thing.box_keyframe.size_m = {0.6, 0.6, 0.8};
    thing.position_plan = Eigen::Vector3d(middle.x(), middle.y(), 0.4);
  };
  stands("bed", {3.3, 1.2});
  lead_to(bed_at({3.3, 1.2}, "bedroom"), {0.6, 1.2}, 0);
  EXPECT_THAT(hear(9),
              ElementsAre("To the bed: about 5 steps.", "Straight on, 4 steps to the bed."))
      << "2 m away is not where they stand";
  stands("chair", {0.6, 2.2});
  lead_to(bed_at({3.3, 1.2}, "bedroom"), {0.6, 1.2}, 0);
  EXPECT_THAT(hear(4), ElementsAre("To the bed: about 5 steps.", "The chair is on your left."));
}

TEST_F(GuidanceTest, TheEndOfTheTurnBeforeIsNotTakenForTheOneThatIsTold) {
  lead_to(bed_at({1, 3}, "bedroom"), {1, 1}, -kPi / 2);
  std::vector<std::string> said;
  while (guidance_->state() != State::kTurning) said = hear(0.2);
  ASSERT_THAT(said, ElementsAre("Turn around."));
  const double told_s = speaking_s(said[0]);
  EXPECT_THAT(hear(0.4, 0, 1), IsEmpty());
  EXPECT_THAT(hear(told_s + 0.6), IsEmpty()) << "they turned before they had heard it";
  EXPECT_THAT(hear(2), ElementsAre(AnyOf(StartsWith("Turn to"), "Turn around.")));
}

// Two ways around a table are as long as each other.
TEST_F(GuidanceTest, WhoTurnsIsNotTurnedAgainSinceAnotherWayIsShorterFromAHandsBreadthBeside) {
  grid_ = testing::Floor(60, 40).fill({20, 12}, {30, 28}, FloorCell::kOccupied).grid();
  has_rooms_ = false;
  lead_to(bed_at({5, 2}, "hall"), {1, 1.97}, kPi);
  while (guidance_->state() != State::kTurning) (void)hear(0.2);
  const Vector2d next = guidance_->next_place().value();
  ASSERT_LT(next.y(), 1.9);
  (void)hear(3);
  place_.y() = 2.03;
  heading_rad_ = heading_to(place_, next);
  EXPECT_THAT(hear(4), ElementsAre(StartsWith("Straight on")));
  EXPECT_EQ(guidance_->next_place(), next);
}

TEST_F(GuidanceTest, ADoorThatOneWalksThroughIsAnnouncedAndPassed) {
  lead_to(room("kitchen"), {1, 3.45}, 0);
  EXPECT_THAT(hear(7), ElementsAre("To the kitchen: about 7 steps.", "The door is ahead of you.",
                                   "Straight on, 6 steps to the door."));
  const auto said = hear(8, 0.6);
  ASSERT_EQ(said.size(), 3u);
  EXPECT_EQ(said[2], "You are there, in the kitchen.");
  EXPECT_EQ(said[0], "In 2 steps: through the door.") << "when it has been heard";
  EXPECT_THAT(said[1], StartsWith("Through the door, "));
  EXPECT_EQ(guidance_->state(), State::kArrived);
  EXPECT_THAT(hear(20), IsEmpty());
}

// Nobody looked to where its frame stands.
TEST_F(GuidanceTest, WhereAWalkLedThroughAndNoFrameWasSeenTheRoomBeyondIsTold) {
  grid_ = testing::two_rooms().fill({40, 20}, {41, 30}, FloorCell::kUnknown).grid();
  layout_ = testing::layout_of_two_rooms(grid_);
  ASSERT_TRUE(layout_.doorways()[0].is_opening());
  lead_to(bed_at({7.6, 3.3}, "kitchen"), {1, 3.45}, 0);
  EXPECT_THAT(hear(8), ::testing::Contains("Straight on, 6 steps to the kitchen."));
  const auto said = hear(7, 0.6);
  ASSERT_GE(said.size(), 2U);
  EXPECT_EQ(said[0], "In 2 steps you are in the kitchen.");
  EXPECT_THAT(said[1], StartsWith("Now in the kitchen, "));
  EXPECT_THAT(said, Not(::testing::Contains(HasSubstr("door"))));
}

TEST_F(GuidanceTest, WhoWalksAlongAnOpeningIsNotToldOfIt) {
  grid_ = testing::two_rooms().fill({40, 20}, {41, 30}, FloorCell::kUnknown).grid();
  layout_ = testing::layout_of_two_rooms(grid_);
  const rooms::Doorway& opening = layout_.doorways()[0];
  ASSERT_TRUE(opening.is_opening());
  const Vector2d beside = opening.middle_plan - Vector2d(0.3, 0);
  const Vector2d along(0, 1);
  EXPECT_EQ(legs_of({beside - along, beside + along}, layout_.doorways()).size(), 1U);
  const Vector2d through(1, 0);
  EXPECT_EQ(
      legs_of({opening.middle_plan - through, opening.middle_plan + through}, layout_.doorways())
          .size(),
      2U);
}

TEST_F(GuidanceTest, WhoIsLedToADoorHearsHowWideItIs) {
  lead_to(Goal::of(layout_.doorways()[0]), {3.9, 3.45}, 0);
  EXPECT_THAT(hear(12),
              ElementsAre("To the door: about 1 step.", "You are there: the door, right here.",
                          "The door is about 90 centimetres wide."));
}

TEST_F(GuidanceTest, ADoorThatIsNarrowerThanUsualIsAnnouncedSo) {
  grid_ = testing::two_rooms().fill({40, 30}, {41, 33}, FloorCell::kOccupied).grid();
  layout_ = testing::layout_of_two_rooms(grid_);
  ASSERT_LT(layout_.doorways()[0].width_m, 0.75);
  lead_to(room("kitchen"), {0.6, 3.6}, 0);
  EXPECT_THAT(hear(8), ::testing::Contains("Straight on, 7 steps to the door."));
  std::vector<std::string> said;
  while (place_.x() < 3) {
    for (const std::string& text : hear(0.2, 0.5)) said.push_back(text);
  }
  EXPECT_THAT(said, ::testing::Contains(::testing::EndsWith("through the narrow door.")));
  EXPECT_THAT(ask(GuidanceRequest::kRepeat), ::testing::EndsWith("to the narrow door."));
}

TEST_F(GuidanceTest, TheNextActionIsAnnouncedOneAndAHalfToThreeMetresBefore) {
  lead_to(bed_at({7.2, 0.8}, "kitchen"), {0.6, 3.45}, 0);
  (void)hear(8);
  for (int i = 0; i < 60; ++i) {
    const double left_m = layout_.doorways()[0].middle_plan.x() - place_.x();
    for (const Prompt& prompt : go(0.2, 0.6)) {
      if (!prompt.message_id.starts_with("guide.soon")) continue;
      EXPECT_GE(left_m, 1.5);
      EXPECT_LE(left_m, 3.0 + 0.12);
      return;
    }
  }
  FAIL() << "nothing was announced";
}

TEST_F(GuidanceTest, ATurnThatIsTooNearToBeActedOnIsToldWhereItIs) {
  const double door_x = layout_.doorways()[0].middle_plan.x();
  lead_to(bed_at({7.2, 0.8}, "kitchen"), {door_x - 2.2, 3.45}, 0);
  (void)hear(8);
  ASSERT_EQ(guidance_->state(), State::kWalking);
  while (guidance_->state() == State::kWalking && place_.x() < 7) {
    for (const Prompt& prompt : go(0.2, 0.6)) {
      EXPECT_THAT(prompt.message_id, ::testing::Not(StartsWith("guide.soon"))) << prompt.text;
    }
  }
  EXPECT_EQ(guidance_->state(), State::kCorner);
  EXPECT_THAT(hear(4), ::testing::Not(IsEmpty())) << "who stands is told";
}

TEST_F(GuidanceTest, ATurnThatWasAnnouncedIsNotSaidAgainToWhoMakesIt) {
  lead_to(bed_at({7.2, 0.8}, "kitchen"), {0.6, 3.45}, 0);
  (void)hear(8);
  std::string turn;
  while (guidance_->state() == State::kWalking && place_.x() < 7) {
    for (const std::string& text : hear(0.2, 0.6)) turn = text;
  }
  EXPECT_EQ(guidance_->state(), State::kCorner) << turn;
  const Vector2d towards = guidance_->plan().route.back() - place_;
  const double turning =
      std::remainder(std::atan2(towards.y(), towards.x()) - heading_rad_, 2 * kPi);
  const auto said = go(3, 0, turning / 3);
  for (const Prompt& prompt : said) {
    EXPECT_THAT(prompt.message_id, ::testing::Not(StartsWith("guide.turn"))) << prompt.text;
  }
  EXPECT_THAT(hear(2), ElementsAre(StartsWith("Straight on")));
}

TEST_F(GuidanceTest, WhoWalksHearsSomethingAfterFiveMetresOrEightSeconds) {
  grid_ = testing::Floor(140, 16).grid();  // a corridor
  has_rooms_ = false;
  for (const double speed_m_s : {0.4, 0.9}) {
    lead_to(bed_at({13, 0.8}, "hall"), {0.6, 0.8}, 0);
    (void)hear(6.4);
    const double from = place_.x();
    const TimestampNs from_ns = now_ns_;
    std::vector<std::string> said;
    while (said.empty() && place_.x() < 10) said = hear(0.2, speed_m_s);
    ASSERT_THAT(said, ElementsAre(StartsWith("Good. ")));
    EXPECT_THAT(said[0], HasSubstr("to the bed."));
    // It had been silent for a while before it walked.
    const double seconds = seconds_between(from_ns, now_ns_) + 1;
    const double walked_m = place_.x() - from;
    EXPECT_TRUE(seconds > 7 || walked_m > 4.8);
    EXPECT_TRUE(seconds < 9 && walked_m < 5.7) << seconds << " s, " << walked_m << " m";
  }
}

TEST_F(GuidanceTest, OffTheWayAfterThirtyDegreesForTwoSecondsItPlansAnew) {
  lead_to(bed_at({7.3, 0.8}, "kitchen"), {0.6, 3.45}, 0);
  (void)hear(8);
  (void)hear(1, 0.6);
  heading_rad_ = -1;
  std::vector<Prompt> said;
  const TimestampNs turned_ns = now_ns_;
  while (said.empty() && now_ns_ < turned_ns + 10 * kSecond) said = go(0.2, 0.6);
  ASSERT_FALSE(said.empty());
  EXPECT_EQ(said[0].text, "Off the way. Stop.");
  EXPECT_EQ(guidance_->course(), Course::kOffWay);
  EXPECT_NEAR(seconds_between(turned_ns, now_ns_), 2, 0.5);
  const TimestampNs spoken_ns = now_ns_ + static_cast<TimestampNs>(speaking_s(said[0].text) * 1e9);
  said.clear();
  while (said.empty()) said = go(0.2);
  EXPECT_LE(seconds_between(spoken_ns, now_ns_), 1.0);
  EXPECT_THAT(said[0].text, StartsWith("Turn "));
  EXPECT_EQ(guidance_->course(), Course::kOnWay) << "another one";
}

TEST_F(GuidanceTest, OffTheWayAfterAMetreBesideIt) {
  lead_to(bed_at({3.3, 3.3}, "bedroom"), {0.6, 0.6}, kPi / 4);
  (void)hear(8);
  place_ += Vector2d(1.5, -0.6);  // pushed aside, looking at the goal
  heading_rad_ = std::atan2(3.3 - place_.y(), 3.3 - place_.x());
  const auto said = hear(3, 0.3);
  EXPECT_THAT(said, ::testing::Contains("Off the way. Stop."));
}

TEST_F(GuidanceTest, AWordSetsRightWhoVeers) {
  lead_to(room("kitchen"), {0.6, 3.45}, 0);
  (void)hear(8);
  heading_rad_ = 0.35;
  EXPECT_THAT(hear(2, 0.3), ElementsAre("A little to the right."));
}

TEST_F(GuidanceTest, WaitsWhileOneStandsAndRemindsOnce) {
  lead_to(room("kitchen"), {1, 3.45}, 0);
  (void)hear(7);
  EXPECT_THAT(hear(40), ElementsAre("Straight on, 6 steps to the door."));
  EXPECT_EQ(hear(3, 0.3).size(), 1u) << "and goes on with who goes on";
}

// To where a passage lies ahead it is sometimes less than what counts as at a leg's end.
TEST_F(GuidanceTest, WhoDoesNotTakeASmallStepIsNotToldItAgainAndAgain) {
  grid_ = testing::two_rooms()
              .fill({1, 1}, {10, 20}, FloorCell::kOccupied)
              .fill({17, 1}, {40, 20}, FloorCell::kOccupied)
              .grid();
  has_rooms_ = false;
  int small_steps = 0;
  for (double x = 1.0; x < 1.8; x += 0.05) {
    for (double y = 2.1; y < 2.5; y += 0.05) {
      FollowedWay way(map(), bed_at({1.35, -0.4}, "bedroom"), {});
      way.plan_from({.pose = Pose{{x, y}, 0, 0.02}}, BarredFloor(&grid_));
      if (way.is_last_leg() || way.leg().length_m >= kLegEnd_m) continue;
      lead_to(bed_at({1.35, -0.4}, "bedroom"), {x, y}, way.leg().heading_rad());
      const auto said = hear(18);
      const auto told = std::ranges::count(said, "One small step straight on.");
      small_steps += static_cast<int>(told);
      EXPECT_LE(told, 2) << ::testing::PrintToString(said);
    }
  }
  EXPECT_GT(small_steps, 0);
}

TEST_F(GuidanceTest, WhoStandsShortOfTheEndHearsWhatIsLeft) {
  lead_to(bed_at({3.3, 3.3}, "bedroom"), {0.6, 0.6}, kPi / 4);
  (void)hear(8);
  (void)hear(2, 0.6);
  EXPECT_THAT(hear(6), ::testing::Contains(AnyOf(StartsWith("Straight on, 3 steps to the bed"),
                                                 StartsWith("Straight on, 4 steps to the bed"))));
}

TEST_F(GuidanceTest, StopsBeforeADoorThatIsClosed) {
  lead_to(room("kitchen"), {2.6, 3.45}, 0);
  (void)hear(7);
  (void)hear(0.8, 0.6);
  obstacle_m_ = 4.05 - place_.x();
  const auto said = go(0.4, 0.6);
  ASSERT_EQ(said.size(), 1u);
  EXPECT_EQ(said[0].text, "Stop. The door is closed. Open it.");
  EXPECT_EQ(said[0].priority, Priority::kHazard);
}

// Its frame or its leaf is before them then. It is not told to open what is open for ever.
TEST_F(GuidanceTest, WhoComesNoFurtherInADoorIsLedBesideItAndThenToldTheRest) {
  lead_to(room("kitchen"), {2.6, 3.45}, 0);
  (void)hear(7);
  std::vector<std::string> said;
  for (int i = 0; i < 400 && !guidance_->is_over(); ++i) {
    obstacle_m_ = 4.05 - place_.x();
    const bool walks = guidance_->state() == State::kWalking && place_.x() < 3.3;
    for (const std::string& text : hear(0.4, walks ? 0.6 : 0)) said.push_back(text);
    if (!said.empty() && said.back().starts_with("Try a little")) heading_rad_ = 0;
  }
  EXPECT_EQ(std::ranges::count(said, "Stop. The door is closed. Open it."), 1);
  EXPECT_THAT(said, ::testing::Contains("Stop. Something is in the way."));
  EXPECT_THAT(said, ::testing::Contains(StartsWith("Try a little to the ")));
  EXPECT_EQ(guidance_->state(), State::kNearest) << ::testing::PrintToString(said);
}

TEST_F(GuidanceTest, WhoComesNoFurtherInADoorIsLedAnotherWayWhereThereIsOne) {
  grid_ = testing::two_rooms().fill({40, 2}, {42, 12}, FloorCell::kFree).grid();
  lead_to(room("kitchen"), {2.6, 3.45}, 0);
  (void)hear(7);
  std::vector<std::string> said;
  for (int i = 0; i < 400 && (said.empty() || !said.back().starts_with("Turn")); ++i) {
    obstacle_m_ = 4.05 - place_.x();
    const bool walks = guidance_->state() == State::kWalking && place_.x() < 3.3;
    for (const std::string& text : hear(0.4, walks ? 0.6 : 0)) said.push_back(text);
    if (!said.empty() && said.back().starts_with("Try a little")) heading_rad_ = 0;
  }
  EXPECT_FALSE(guidance_->is_over()) << ::testing::PrintToString(said);
  EXPECT_THAT(said, ::testing::Contains("Stop. The door is closed. Open it."));
  EXPECT_THAT(said.back(), StartsWith("Turn ")) << ::testing::PrintToString(said);
}

// Where it knows the place it tells of what is in the way of who walks, and of nothing else.
TEST_F(GuidanceTest, JudgesObstaclesOnlyWhereItKnowsTheirPlace) {
  lead_to(bed_at({7.3, 0.8}, "kitchen"), {0.6, 3.45}, 0);
  (void)hear(8);
  ASSERT_EQ(guidance_->state(), State::kWalking);
  (void)hear(1, 0.6);
  EXPECT_TRUE(guidance_->judges_obstacles(now_ns_));
  is_seen_ = false;
  (void)hear(2, 0.6);
  EXPECT_FALSE(guidance_->judges_obstacles(now_ns_)) << "nobody knows where they are";
  (void)hear(4, 0.6);
  ASSERT_EQ(guidance_->state(), State::kLost);
  EXPECT_FALSE(guidance_->judges_obstacles(now_ns_)) << "nor whether they stand, as they were told";
  (void)hear(8);
  EXPECT_TRUE(guidance_->judges_obstacles(now_ns_)) << "they turn on the spot";
  (void)hear(40);
  EXPECT_FALSE(guidance_->judges_obstacles(now_ns_)) << "but not for ever";
  is_seen_ = true;
  (void)hear(6);
  (void)ask(GuidanceRequest::kPause);
  (void)hear(1);
  EXPECT_FALSE(guidance_->judges_obstacles(now_ns_)) << "they walk as they like";
}

TEST_F(GuidanceTest, WhoWalksIntoACornerWithoutAPlaceHearsOfItAsSoonAsWhoWalks) {
  lead_to(bed_at({7.2, 0.8}, "kitchen"), {0.6, 3.45}, 0);
  (void)hear(8);
  while (guidance_->state() == State::kWalking && place_.x() < 7) (void)hear(0.2, 0.6);
  ASSERT_EQ(guidance_->state(), State::kCorner);
  is_seen_ = false;
  EXPECT_THAT(hear(5, 0.3), ::testing::Contains("I lost where you are. Stop and wait."));
}

TEST_F(GuidanceTest, WhoWalksFastHearsOfWhatComesFromFartherAway) {
  grid_ = testing::Floor(140, 16).grid();  // a corridor
  has_rooms_ = false;
  std::vector<double> left_m;
  for (const double speed_m_s : {0.5, 1.0}) {
    lead_to(bed_at({13, 0.8}, "hall"), {0.6, 0.8}, 0);
    (void)hear(6.4);
    while (guidance_->state() == State::kWalking && place_.x() < 12) {
      const double now_left_m = 12.5 - place_.x();
      for (const Prompt& prompt : go(0.2, speed_m_s)) {
        if (prompt.message_id == "guide.soon_goal") left_m.push_back(now_left_m);
      }
    }
  }
  ASSERT_EQ(left_m.size(), 2u);
  EXPECT_GT(left_m[1], left_m[0] + 0.3);
}

TEST_F(GuidanceTest, StopsBeforeWhatStandsInTheWayAndLeadsAroundIt) {
  lead_to(bed_at({3.3, 3.3}, "bedroom"), {0.6, 0.6}, kPi / 4);
  (void)hear(8);
  (void)hear(1, 0.6);
  obstacle_m_ = 0.6;
  const auto said = go(0.4, 0.6);
  ASSERT_FALSE(said.empty());
  EXPECT_EQ(said[0].text, "Stop. Something is in the way.");
  obstacle_m_.reset();
  const auto then = go(4);
  ASSERT_FALSE(then.empty());
  EXPECT_THAT(then[0].message_id,
              AnyOf(StartsWith("guide.turn_hour_"), "guide.little_left", "guide.little_right"));
}

TEST_F(GuidanceTest, NobodyIsSentIntoWhatStandsBeforeThem) {
  grid_ = testing::Floor(140, 24).grid();
  has_rooms_ = false;
  lead_to(bed_at({13, 1.2}, "hall"), {0.6, 1.2}, 0);
  obstacle_m_ = 0.8;
  EXPECT_THAT(hear(1), ElementsAre(StartsWith("To the bed")));
  std::vector<Prompt> said;
  while (said.empty()) said = go(0.2);
  EXPECT_EQ(said[0].text, "Stop. Something is in the way.");
  EXPECT_EQ(said[0].priority, Priority::kHazard);
  obstacle_m_.reset();
  const auto then = go(4);
  ASSERT_FALSE(then.empty());
  EXPECT_THAT(then[0].message_id,
              AnyOf(StartsWith("guide.turn_hour_"), StartsWith("guide.little")));
}

// They walk past a table that the map knows, whose edge is at y = 1.1 m.
class PastATable : public GuidanceTest {
 protected:
  PastATable() {
    grid_ = testing::Floor(140, 24).fill({50, 1}, {56, 11}, FloorCell::kOccupied).grid();
    has_rooms_ = false;
    KnownThing& table = things_.emplace_back();
    table.name = "table";
    table.probability = 0.9;
    table.box_keyframe.size_m = {0.6, 1, 0.7};
    table.position_plan = Eigen::Vector3d(5.3, 0.6, 0.35);
  }
  void walk_up_to_it() {
    lead_to(bed_at({13, 1.6}, "hall"), {0.6, 1.6}, 0);
    (void)hear(8);
    while (place_.x() < 4.3) (void)hear(0.2, 0.6);
  }
  // Their right shoulder would touch it.
  std::vector<std::string> drift_to_it() {
    place_.y() = 1.1;
    heading_rad_ = 0;
    sees_floor_ = true;
    return hear(0.6, 0.4);
  }
  // Of what the next picture shows there, as seen by who stands at (4.3, 1.6) and faces so.
  std::string message_of(const Vector2d& obstacle, double heading_rad) {
    Walker sees = walker();
    sees.now_ns = sees.pose_ns = now_ns_ += kTick;
    sees.pose = Pose{{4.3, 1.6}, heading_rad, 0.02};
    sees.obstacles = {obstacle};
    const auto prompt = guidance_->update(sees);
    return prompt ? prompt->message_id : "";
  }
};

TEST_F(PastATable, WhatTheMapHasInTheWayIsNamed) {
  KnownThing& rug = things_.emplace_back(things_[0]);
  rug.name = "rug";
  rug.box_keyframe.size_m = {2, 2, 0.02};
  rug.position_plan->z() = 0.01;
  walk_up_to_it();
  EXPECT_THAT(drift_to_it(), ElementsAre("Stop: the table is in the way."));
}

TEST_F(PastATable, WithoutASurePlaceNothingIsNamed) {
  walk_up_to_it();
  sigma_m_ = 0.3;
  EXPECT_THAT(drift_to_it(), ElementsAre("Stop. Something is in the way."));
}

TEST_F(PastATable, SomebodyBesideItIsNotNamedByIt) {
  things_[0].box_keyframe.size_m.y() = 1.6;  // the box is larger than what was seen: to y = 1.4 m
  walk_up_to_it();
  EXPECT_EQ(message_of({5, 1.42}, 0), "guide.stop_obstacle_right");
}

TEST_F(PastATable, SidesAreThoseOfTheBody) {
  walk_up_to_it();
  // To the left of the line to the leg's end, but they face further to the left.
  EXPECT_EQ(message_of({5.25, 1.71}, 0.25), "guide.stop_obstacle_right");
}

// Where nobody comes past: somebody who will go on.
TEST_F(GuidanceTest, WaitsForWhatStandsWhereThereIsNoWayAround) {
  grid_ = testing::Floor(140, 10).grid();
  has_rooms_ = false;
  lead_to(bed_at({13, 0.5}, "hall"), {0.6, 0.5}, 0);
  (void)hear(8);
  (void)hear(0.4, 0.6);
  obstacle_m_ = 0.8;
  EXPECT_THAT(hear(0.4, 0.6), ElementsAre("Stop. Something is in the way."));
  const auto waiting = hear(3);
  obstacle_m_.reset();
  EXPECT_FALSE(guidance_->is_over()) << ::testing::PrintToString(waiting);
  EXPECT_THAT(hear(8), ::testing::Contains(::testing::StartsWith("Straight on")));
}

class InACorridor : public GuidanceTest {
 protected:
  // Told that there is no way around who stands before them, and waiting.
  void wait_before_somebody() {
    grid_ = testing::Floor(140, 8).grid();
    has_rooms_ = false;
    lead_to(bed_at({13, 0.4}, "hall"), {0.6, 0.4}, 0);
    (void)hear(8);
    (void)hear(0.4, 0.6);
    obstacle_m_ = 0.8;
    EXPECT_THAT(hear(4), ElementsAre("Stop. Something is in the way.", "I know no way around it."));
    EXPECT_EQ(guidance_->course(), Course::kWaits);
  }
};

TEST_F(InACorridor, WhoMayGoIsWaitedForAndNobodyIsSentAtThemMeanwhile) {
  wait_before_somebody();
  EXPECT_THAT(hear(15), ElementsAre("If somebody stands there, ask to pass."));
  EXPECT_EQ(guidance_->course(), Course::kWaits);
  EXPECT_THAT(hear(6), ::testing::Contains(StartsWith("Stop."))) << "it does not wait for ever";
}

TEST_F(InACorridor, OnceTheWayIsSeenFreeItGoesOn) {
  wait_before_somebody();
  (void)hear(8);
  obstacle_m_.reset();
  is_seen_ = false;
  EXPECT_THAT(hear(0.8), IsEmpty()) << "no picture shows it";
  is_seen_ = true;
  EXPECT_THAT(hear(0.4), ElementsAre(StartsWith("Straight on")));
}

TEST_F(InACorridor, WhoAsksWhileTheyWaitHearsWhatFor) {
  wait_before_somebody();
  EXPECT_EQ(ask(GuidanceRequest::kRepeat), "If somebody stands there, ask to pass.");
  EXPECT_EQ(ask(GuidanceRequest::kNext), "If somebody stands there, ask to pass.");
  EXPECT_EQ(guidance_->course(), Course::kWaits);
}

TEST_F(InACorridor, WhoTurnsAsideOrIsSeenWithoutDepthHasNoFreeWay) {
  wait_before_somebody();
  obstacle_m_.reset();
  has_depth_ = false;
  EXPECT_THAT(hear(6), ElementsAre("If somebody stands there, ask to pass."));
  has_depth_ = true;
  heading_rad_ = 0.6;
  EXPECT_THAT(hear(4), IsEmpty());
  EXPECT_EQ(guidance_->course(), Course::kWaits);
  heading_rad_ = 0;
  EXPECT_THAT(hear(3), ElementsAre(StartsWith("Straight on")));
}

TEST_F(InACorridor, TheSecondBlockageIsWaitedForAloud) {
  wait_before_somebody();
  (void)hear(8);
  obstacle_m_.reset();
  (void)hear(5);
  (void)hear(6, 0.6);
  obstacle_m_ = 0.8;
  EXPECT_THAT(hear(10), ::testing::IsSupersetOf({"I know no way around it.",
                                                 "If somebody stands there, ask to pass."}));
}

TEST_F(InACorridor, WhoGoesOnAfterAPauseWaitsNoMore) {
  wait_before_somebody();
  (void)ask(GuidanceRequest::kPause);
  obstacle_m_.reset();
  has_depth_ = false;
  (void)ask(GuidanceRequest::kResume);
  EXPECT_THAT(hear(3), ElementsAre(StartsWith("Straight on")));
}

// The walls of a narrow hall are always close, and the plan leads between them.
TEST_F(GuidanceTest, WhatTheMapKnowsIsPassedWithoutAWord) {
  grid_ = testing::Floor(140, 10).fill({60, 1}, {70, 3}, FloorCell::kOccupied).grid();
  has_rooms_ = false;
  lead_to(bed_at({13, 0.5}, "hall"), {0.6, 0.5}, 0);
  (void)hear(8);
  std::vector<std::string> said;
  while (place_.x() < 11) {
    place_.y() = place_.x() > 5 && place_.x() < 8 ? 0.6 : 0.5;
    sees_floor_ = true;
    for (const std::string& text : hear(0.2, 0.6)) said.push_back(text);
  }
  EXPECT_THAT(said, ::testing::Not(::testing::Contains(HasSubstr("in the way"))));
}

// Who does not go where they were told to is stopped before it, too, and turned.
TEST_F(GuidanceTest, WhoHeadsForAWallBesideTheWayIsStopped) {
  grid_ = testing::Floor(140, 16).grid();
  has_rooms_ = false;
  lead_to(bed_at({13, 0.8}, "hall"), {0.6, 0.8}, 0);
  (void)hear(8);
  (void)hear(1, 0.6);
  heading_rad_ = kPi / 3;
  sees_floor_ = true;
  EXPECT_THAT(hear(0.4, 0.6), ElementsAre("Stop. Something is in the way."));
  EXPECT_THAT(hear(4), ElementsAre(HasSubstr("urn")));
}

// Of who walks beside the line, where the map's own table stands in theirs.
TEST_F(GuidanceTest, WhoHasDriftedToWhatTheMapKnowsIsStoppedBeforeIt) {
  grid_ = testing::Floor(140, 24).fill({50, 1}, {56, 11}, FloorCell::kOccupied).grid();
  has_rooms_ = false;
  lead_to(bed_at({13, 1.6}, "hall"), {0.6, 1.6}, 0);
  (void)hear(8);
  ASSERT_EQ(guidance_->state(), State::kWalking);
  while (place_.x() < 3.9) (void)hear(0.2, 0.6);
  place_.y() = 0.9;
  heading_rad_ = 0.07;
  sees_floor_ = true;
  EXPECT_THAT(hear(1, 0.4), ::testing::Contains("Stop. Something is in the way."));
}

TEST_F(GuidanceTest, WhoWalksCloseAlongAWallIsNotStoppedBeforeIt) {
  grid_ = testing::Floor(140, 16).grid();
  has_rooms_ = false;
  lead_to(bed_at({13, 0.8}, "hall"), {0.6, 0.8}, 0);
  (void)hear(8);
  ASSERT_EQ(guidance_->state(), State::kWalking);
  sees_floor_ = true;
  std::vector<std::string> said;
  while (place_.x() < 9) {
    place_.y() = 0.22;  // 0.12 m from it
    for (const std::string& text : hear(0.2, 0.6)) said.push_back(text);
  }
  EXPECT_THAT(said, ::testing::Not(::testing::Contains(HasSubstr("in the way"))));
}

TEST_F(GuidanceTest, WhatTheMapKnowsIsToldOnceToWhoStandsBeforeIt) {
  grid_ = testing::Floor(140, 24).fill({50, 1}, {56, 11}, FloorCell::kOccupied).grid();
  has_rooms_ = false;
  lead_to(bed_at({13, 1.6}, "hall"), {0.6, 1.6}, 0);
  (void)hear(8);
  while (place_.x() < 3.9) (void)hear(0.2, 0.6);
  place_.y() = 0.9;
  sees_floor_ = true;
  std::vector<std::string> said;
  for (int i = 0; i < 400 && !guidance_->is_over(); ++i) {
    // They stand, and face where they are told to go, as if they had moved a little.
    for (const std::string& text : hear(0.4, 0.02)) said.push_back(text);
    place_.x() = 3.9;
  }
  EXPECT_LE(std::ranges::count(said, "Stop. Something is in the way."), 1);
}

TEST_F(GuidanceTest, WhatStandsWhereTheMapNeverLookedIsAnObstacle) {
  grid_ = testing::Floor(140, 10).fill({40, 1}, {43, 4}, FloorCell::kUnknown).grid();
  has_rooms_ = false;
  lead_to(bed_at({13, 0.5}, "hall"), {0.6, 0.5}, 0);
  (void)hear(8);
  while (place_.x() < 3.3) (void)hear(0.2, 0.6);
  Walker sees = walker();
  sees.now_ns = sees.pose_ns = now_ns_ += kTick;
  sees.obstacles = {Vector2d(4.15, 0.35)};
  const auto prompt = guidance_->update(sees);
  ASSERT_TRUE(prompt);
  EXPECT_EQ(prompt->message_id, "guide.stop_obstacle_right");
}

// Only what they are led up to is no obstacle; a spot is stood on.
TEST_F(GuidanceTest, WhatStandsBeforeASpotIsTold) {
  Goal spot;
  spot.kind = Goal::Kind::kSpot;
  spot.noun = {Noun::Kind::kThing, "my place"};
  spot.outline = Outline{{3, 1.2}, {0, 0}};
  spot.room = "bedroom";
  lead_to(spot, {1, 1.2}, 0);
  (void)hear(8);
  while (place_.x() < 2) (void)hear(0.2, 0.5);
  obstacle_m_ = 0.5;
  EXPECT_THAT(hear(0.4, 0.5), ::testing::Contains("Stop. Something is in the way."));
}

// What fills the picture takes the place away, too.
TEST_F(GuidanceTest, WhoIsNoMorePlacedHasWhatIsAheadToldByOthersAtOnce) {
  lead_to(bed_at({7.3, 0.8}, "kitchen"), {0.6, 3.45}, 0);
  (void)hear(8);
  (void)hear(1, 0.6);
  ASSERT_TRUE(guidance_->judges_obstacles(now_ns_));
  is_seen_ = false;
  (void)hear(0.2, 0.6);
  EXPECT_FALSE(guidance_->judges_obstacles(now_ns_));
}

TEST_F(GuidanceTest, WhoDoesNotTurnForLongHasWhatIsAheadToldByOthers) {
  lead_to(room("kitchen"), {1, 3.45}, kPi);
  (void)hear(9);
  ASSERT_EQ(guidance_->state(), State::kTurning);
  is_seen_ = false;
  EXPECT_TRUE(guidance_->judges_obstacles(now_ns_)) << "turns on the spot, as they were told";
  (void)hear(50, 0.3);
  EXPECT_FALSE(guidance_->judges_obstacles(now_ns_));
}

// They turned as they were told, and did not wait for how far to walk.
TEST_F(GuidanceTest, WhoTurnsAndWalksOnIsStoppedAndHearsOfObstacles) {
  lead_to(bed_at({1, 3}, "bedroom"), {1, 1}, 0);
  while (guidance_->state() != State::kTurning) (void)hear(0.2);
  EXPECT_TRUE(guidance_->judges_obstacles(now_ns_));
  EXPECT_THAT(hear(0.6, 0.5, kPi / 2 / 0.6), IsEmpty());
  EXPECT_THAT(hear(1, 0.5), IsEmpty()) << "they have just heard of the turn";
  ASSERT_EQ(guidance_->state(), State::kTurning);
  EXPECT_FALSE(guidance_->judges_obstacles(now_ns_)) << "nobody walks on the spot";
  EXPECT_THAT(hear(2, 0.5), ElementsAre("Stop."));
}

// What was seen from a place that jumped is not there.
TEST_F(GuidanceTest, WhatIsSeenFromAPlaceThatIsNotBelievedIsNoObstacle) {
  lead_to(bed_at({3.3, 3.3}, "bedroom"), {0.6, 0.6}, kPi / 4);
  (void)hear(8);
  (void)hear(1, 0.6);
  Walker wrong = walker();
  wrong.now_ns = now_ns_ += kTick;
  wrong.pose = Pose{{3.6, 0.5}, kPi / 4, 0.02};
  wrong.pose_ns = wrong.now_ns;
  wrong.obstacles = {place_ + Vector2d(0.3, 0.3)};
  EXPECT_EQ(guidance_->update(wrong), std::nullopt);
}

TEST_F(GuidanceTest, WhatNeverGoesIsTriedBesideAndThenTheRestIsTold) {
  grid_ = testing::Floor(140, 8).grid();  // a corridor without room beside anybody
  has_rooms_ = false;
  lead_to(bed_at({13, 0.4}, "hall"), {0.6, 0.4}, 0);
  (void)hear(8);
  (void)hear(0.4, 0.6);
  std::vector<std::string> said;
  for (int i = 0; i < 400 && !guidance_->is_over(); ++i) {
    obstacle_m_ = 0.8;
    for (const Prompt& prompt : go(0.4)) {
      said.push_back(prompt.text);
      if (prompt.message_id.starts_with("guide.try_left")) heading_rad_ += 0.2;
      if (prompt.message_id.starts_with("guide.try_right")) heading_rad_ -= 0.2;
    }
  }
  EXPECT_EQ(guidance_->state(), State::kNearest) << ::testing::PrintToString(said);
  EXPECT_THAT(said, ::testing::Contains(StartsWith("Try a little to the ")));
  EXPECT_LE(std::ranges::count(said, "I know no way around it."), 5);
  EXPECT_EQ(hear(3).front(), "Something is in the way here. Ask again later.");
  EXPECT_THAT(hear(9), ElementsAre(HasSubstr("o'clock"))) << "and nothing of what the map knows";
}

// Nearer a camera sees one front and no place; from farther away nobody knows how they went.
TEST_F(GuidanceTest, WhoWalksTheLastStepUnseenIsToldThatTheyShouldBeThere) {
  for (const double seen_to_x : {1.9, 1.4}) {
    is_seen_ = true;
    lead_to(bed_at({3.3, 1.2}, "bedroom"), {1, 1.2}, 0);
    (void)hear(8);
    while (place_.x() < seen_to_x) (void)hear(0.2, 0.5);
    is_seen_ = false;
    std::vector<std::string> said = hear(0.8, 0.5);
    for (const std::string& text : hear(20)) said.push_back(text);
    EXPECT_EQ(guidance_->is_over(), seen_to_x > 1.5);
    if (seen_to_x > 1.5) {
      EXPECT_THAT(said,
                  ElementsAre("You should be there: the bed ahead, in reach.", "At knee height.",
                              "I stop here. If that is not the bed, ask again."));
    } else {
      EXPECT_THAT(said, ::testing::Contains("I lost where you are. Stop and wait."));
    }
  }
}

TEST_F(GuidanceTest, WhoShouldBeThereAndIsNotIsLedOn) {
  lead_to(bed_at({3.3, 1.2}, "bedroom"), {1, 1.2}, 0);
  (void)hear(8);
  while (place_.x() < 1.9) (void)hear(0.2, 0.5);
  is_seen_ = false;
  EXPECT_THAT(hear(5), ::testing::Contains(StartsWith("You should be there")));
  is_seen_ = true;  // and stands where they stood
  EXPECT_THAT(hear(4), ElementsAre(StartsWith("Straight on"))) << "at once";
  EXPECT_FALSE(guidance_->is_over());
}

TEST_F(GuidanceTest, WhoStandsOnASpotHasItOnNoSide) {
  Goal spot;
  spot.kind = Goal::Kind::kSpot;
  spot.noun = {Noun::Kind::kThing, "spot"};
  spot.outline = Outline{{2, 2}};
  spot.room = "bedroom";
  lead_to(spot, {2.02, 1.97}, 0.3);
  EXPECT_EQ(hear(4).back(), "You are there: the spot, right here.");
  EXPECT_EQ(there_phrase(spot, Pose{{1.6, 2}, 0}).message_id, "guide.there_ahead");
  spot.kind = Goal::Kind::kThing;
  EXPECT_EQ(there_phrase(spot, Pose{{2.05, 2}, 0}).message_id, "guide.there_behind")
      << "of what a hand is at it is told";
}

TEST_F(GuidanceTest, TheLastMetreIsBySideReachAndHeight) {
  lead_to(bed_at({3.3, 1.2}, "bedroom"), {1, 1.2}, 0);
  (void)hear(8);
  std::vector<std::string> said;
  while (guidance_->state() != State::kArrived && place_.x() < 3) {
    said = hear(0.2, 0.5);
  }
  EXPECT_THAT(said, ElementsAre("You are there: the bed ahead, in reach."));
  EXPECT_LE(2.8 - place_.x(), 0.3 + 0.25);
  EXPECT_THAT(hear(5), ElementsAre("At knee height."));
  EXPECT_THAT(hear(30), IsEmpty());
}

class GoalBearingTest : public GuidanceTest {
 protected:
  GoalBearingTest() {
    grid_ = testing::two_rooms().fill({25, 15}, {35, 25}, FloorCell::kOccupied).grid();
    has_rooms_ = false;
  }
  [[nodiscard]] bool has_bearing() const { return guidance_->goal_bearing().has_value(); }
};

TEST_F(GoalBearingTest, IsAtAThingThatIsNearUntilOneIsThere) {
  lead_to(bed_at({3, 2}, "bedroom"), {0.6, 2}, -0.36);  // to its corner
  (void)hear(7.4);
  EXPECT_FALSE(has_bearing()) << "nearly 2 m away";
  (void)hear(1, 0.6);
  ASSERT_TRUE(has_bearing());
  const Vector2d towards = guidance_->plan().touch_plan - place_;
  const double bearing_rad = std::atan2(towards.y(), towards.x()) - heading_rad_;
  EXPECT_NEAR(guidance_->goal_bearing()->distance_m, towards.norm(), 1e-6);
  EXPECT_NEAR(guidance_->goal_bearing()->bearing_rad, bearing_rad, 1e-6);
  for (int i = 0; i < 20 && guidance_->state() != State::kArrived; ++i) (void)hear(0.4, 0.25);
  EXPECT_EQ(guidance_->state(), State::kArrived);
  EXPECT_FALSE(has_bearing());
}

TEST_F(GoalBearingTest, IsToTheRightOfWhoTurnsToTheLeft) {
  lead_to(bed_at({3, 2}, "bedroom"), {1.2, 2}, 0);
  (void)hear(9);
  ASSERT_TRUE(has_bearing());
  const double bearing_rad = guidance_->goal_bearing()->bearing_rad;
  (void)hear(1, 0, 0.5);
  ASSERT_TRUE(has_bearing());
  EXPECT_NEAR(guidance_->goal_bearing()->bearing_rad, bearing_rad - 0.5, 1e-6);
}

TEST_F(GoalBearingTest, RestsOnAPlaceThatIsSure) {
  lead_to(bed_at({3, 2}, "bedroom"), {1.2, 2}, 0);
  (void)hear(9);
  ASSERT_TRUE(has_bearing());
  sigma_m_ = 0.4;
  (void)hear(0.2);
  EXPECT_FALSE(has_bearing()) << "well enough to be led, not to be told the direction from so near";
  sigma_m_ = 0.02;
  (void)hear(0.2);
  EXPECT_TRUE(has_bearing());
  is_seen_ = false;
  (void)hear(0.2);
  EXPECT_FALSE(has_bearing());
}

TEST_F(GoalBearingTest, IsAtNothingThatMayHaveGone) {
  Goal bed = bed_at({3, 2}, "bedroom");
  bed.is_sure = false;
  lead_to(bed, {1.2, 2}, 0);
  (void)hear(9);
  EXPECT_FALSE(has_bearing());
}

TEST_F(GoalBearingTest, IsAtNoPlaceThatOneStandsOn) {
  Goal spot = bed_at({3, 2}, "bedroom");
  spot.kind = Goal::Kind::kSpot;
  lead_to(spot, {1.2, 2}, 0);
  (void)hear(9);
  EXPECT_FALSE(has_bearing());
}

TEST_F(GoalBearingTest, WaitsWhileSomethingElseIsToBeDone) {
  lead_to(bed_at({3, 2}, "bedroom"), {1.2, 2}, 0);
  (void)hear(9);
  ASSERT_TRUE(has_bearing());
  (void)ask(GuidanceRequest::kPause);
  (void)hear(0.2);
  EXPECT_FALSE(has_bearing());
  (void)ask(GuidanceRequest::kResume);
  (void)hear(5);
  ASSERT_TRUE(has_bearing());
  (void)hear(0.4, 0.5);
  obstacle_m_ = 0.4;
  (void)hear(0.4, 0.5);
  EXPECT_EQ(guidance_->state(), State::kStopped);
  EXPECT_FALSE(has_bearing());
}

// A shelf, at whose side the way ends: straight at the thing they would walk into its corner.
TEST_F(GoalBearingTest, LeadsNobodyIntoWhatStandsBesideTheWay) {
  grid_ = testing::two_rooms().fill({13, 23}, {39, 39}, FloorCell::kOccupied).grid();
  Goal jar = bed_at({2, 2.9}, "bedroom");
  jar.outline->size_m = {0.2, 0.2};
  lead_to(jar, {0.9, 2}, 0);
  (void)hear(9);
  EXPECT_EQ(guidance_->state(), State::kWalking);
  EXPECT_FALSE(has_bearing());
  (void)hear(1, 0.7);
  ASSERT_TRUE(has_bearing());
  EXPECT_GT(guidance_->goal_bearing()->bearing_rad, kPi / 4);
}

TEST_F(GuidanceTest, WhoLooksOnSeesHowItGoesAndWhatIsLeft) {
  lead_to(bed_at({3.3, 1.2}, "bedroom"), {1, 1.2}, 0);
  EXPECT_EQ(guidance_->left_m(), std::nullopt) << "nobody knows the way yet";
  (void)hear(8);
  EXPECT_EQ(to_string(guidance_->course()), "on_way");
  ASSERT_TRUE(guidance_->left_m());
  const double before_m = *guidance_->left_m();
  (void)hear(1, 0.5);
  EXPECT_NEAR(*guidance_->left_m(), before_m - 0.5, 0.15);
  (void)guidance_->request(GuidanceRequest::kPause, now_ns_);
  EXPECT_EQ(to_string(guidance_->course()), "paused");
  (void)guidance_->request(GuidanceRequest::kResume, now_ns_);
  is_seen_ = false;
  (void)hear(20);
  EXPECT_EQ(to_string(guidance_->course()), "lost");
  EXPECT_EQ(guidance_->left_m(), std::nullopt);
  (void)guidance_->request(GuidanceRequest::kEnd, now_ns_);
  EXPECT_EQ(to_string(guidance_->course()), "ended");
}

// Of 0.6 m in cells of 0.1 m: ways that keep 0.3 m to each side end before it.
TEST_F(GuidanceTest, TheWayToANarrowDoorEndsInItsFrame) {
  grid_ = testing::two_rooms().fill({40, 1}, {41, 33}, FloorCell::kOccupied).grid();
  layout_ = testing::layout_of_two_rooms(grid_);
  ASSERT_TRUE(layout_.doorways()[0].is_door());
  lead_to(Goal::of(layout_.doorways()[0]), {2.4, 3.6}, 0);
  (void)hear(8);
  ASSERT_TRUE(guidance_->next_place());
  EXPECT_NEAR(guidance_->next_place()->x(), 4, 0.11);
}

TEST_F(GuidanceTest, WhoIsThereHearsWhatItLiesOn) {
  Goal bed = bed_at({3.3, 1.2}, "bedroom");
  bed.on = "table";
  lead_to(bed, {1, 1.2}, 0);
  (void)hear(8);
  while (guidance_->state() != State::kArrived && place_.x() < 3) (void)hear(0.2, 0.5);
  EXPECT_THAT(hear(12), ElementsAre("On the table.", "At knee height."));
}

TEST_F(GuidanceTest, WhoIsThereHearsWhatAHelperNoted) {
  Goal bed = bed_at({3.3, 1.2}, "bedroom");
  bed.note = "low beam above it";
  lead_to(bed, {1, 1.2}, 0);
  (void)hear(8);
  while (guidance_->state() != State::kArrived && place_.x() < 3) (void)hear(0.2, 0.5);
  EXPECT_THAT(hear(12), ElementsAre("At knee height.", "Note: low beam above it."));
}

TEST_F(GuidanceTest, WhoIsLostHearsRoomsAndNoDirections) {
  lead_to(bed_at({7.3, 0.8}, "kitchen"), {0.6, 3.45}, 0);
  (void)hear(8);
  (void)hear(1, 0.6);
  is_seen_ = false;
  EXPECT_THAT(hear(4, 0.6), ElementsAre("I lost where you are. Stop and wait."));
  EXPECT_EQ(guidance_->state(), State::kLost);
  EXPECT_THAT(hear(7), ElementsAre("I do not know where you stand. Turn slowly."));
  room_ = "bedroom";
  EXPECT_THAT(hear(5), ElementsAre("The bed is in the kitchen, the next room."));
  room_ = "kitchen";
  EXPECT_THAT(hear(5), ElementsAre("The bed is in this room."));
  EXPECT_THAT(hear(30), ElementsAre("I do not know where you stand. Turn slowly."));
  is_seen_ = true;
  const auto said = hear(5);
  ASSERT_GE(said.size(), 2u);
  EXPECT_EQ(said[0], "Stop. I know again where you are.");
}

TEST_F(GuidanceTest, WhoWalksUnseenIsToldToStandAndToTurnOnlyWhereThatDoesNotHelp) {
  lead_to(bed_at({7.3, 0.8}, "kitchen"), {0.6, 3.45}, 0);
  (void)hear(8);
  (void)hear(1, 0.6);
  is_seen_ = false;
  const auto said = go(5, 0.3);
  ASSERT_EQ(texts(said), std::vector<std::string>{"I lost where you are. Stop and wait."});
  EXPECT_EQ(said[0].confidence, Confidence::kUnsure);
  EXPECT_EQ(said[0].sound, Sound::kLost);
  EXPECT_THAT(hear(4), IsEmpty()) << "it has just been heard";
  const auto turn = go(3);
  EXPECT_EQ(texts(turn), std::vector<std::string>{"I do not know where you stand. Turn slowly."});
  is_seen_ = true;
  const auto found = hear(6, 0, 0.3);
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found[0], "Stop. I know again where you are.") << "since they turn";
}

TEST_F(GuidanceTest, WhoStandsIsLeftInPeaceForLongerBeforeTheyAreLost) {
  lead_to(bed_at({7.3, 0.8}, "kitchen"), {1, 3.45}, kPi);
  (void)hear(9);
  ASSERT_EQ(guidance_->state(), State::kTurning);
  is_seen_ = false;
  EXPECT_THAT(hear(7), IsEmpty());
  EXPECT_THAT(hear(8), ::testing::Contains("I lost where you are. Stop and wait."));
}

// Before a bare wall, say: once more lost they would turn back to where they are seen, and so on.
TEST_F(GuidanceTest, WhoIsNotSeenAfterATurnGoesAStepAndIsThenLost) {
  lead_to(bed_at({7.3, 0.8}, "kitchen"), {1, 3.45}, kPi);
  (void)hear(9);
  ASSERT_EQ(guidance_->state(), State::kTurning);
  is_seen_ = false;
  const auto said = go(16);
  EXPECT_THAT(texts(said),
              ElementsAre("Straight on, 2 steps.", "I lost where you are. Stop and wait."));
  EXPECT_EQ(said[0].confidence, Confidence::kProbable);
}

TEST_F(GuidanceTest, NoStepIsToldUnseenTowardsWhatDepthShows) {
  lead_to(bed_at({7.3, 0.8}, "kitchen"), {1, 3.45}, kPi);
  (void)hear(9);
  ASSERT_EQ(guidance_->state(), State::kTurning);
  is_seen_ = false;
  depth_m_ = 0.6;
  EXPECT_THAT(hear(12), ElementsAre("I lost where you are. Stop and turn slowly."));
}

// A room has no front before which no picture is placed.
TEST_F(GuidanceTest, NobodyShouldBeInARoomUnseen) {
  lead_to(room("kitchen"), {2.6, 3.45}, 0);
  (void)hear(7);
  while (place_.x() < 4) (void)hear(0.2, 0.5);
  is_seen_ = false;
  EXPECT_THAT(hear(12), ::testing::Contains("I lost where you are. Stop and wait."));
}

TEST_F(GuidanceTest, APlaceThatNobodyWalksToIsNotBelievedAtOnce) {
  lead_to(room("kitchen"), {0.6, 3.45}, 0);
  (void)hear(8);
  (void)hear(1, 0.6);
  const Vector2d here = place_;
  place_ = {7, 1};  // a wrong answer
  EXPECT_THAT(hear(0.2), IsEmpty());
  place_ = here;
  (void)hear(1, 0.6);
  EXPECT_EQ(guidance_->state(), State::kWalking);
}

TEST_F(GuidanceTest, WhoIsBarredShortOfTheThingHasNotArrivedYet) {
  grid_ = testing::two_rooms().fill({68, 3}, {78, 13}, FloorCell::kOccupied).grid();
  lead_to(bed_at({7.3, 0.8}, "kitchen"), {5.4, 0.8}, 0.5);
  (void)hear(8);
  ASSERT_EQ(guidance_->state(), State::kWalking);
  place_ = {6.2, 1.1};
  (void)hear(1);
  EXPECT_THAT(ask(GuidanceRequest::kBlocked), Not(HasSubstr("You are there")))
      << "the bed is 0.6 m beside the way";
  place_ = {6.4, 1.2};
  (void)hear(6);
  EXPECT_THAT(ask(GuidanceRequest::kBlocked), StartsWith("You are there"));
}

TEST_F(GuidanceTest, WhoStandsBesideAPassageIsLedBeforeItFirst) {
  // From 1 m to 1.7 m, below y = 2.
  grid_ = testing::two_rooms()
              .fill({1, 1}, {10, 20}, FloorCell::kOccupied)
              .fill({17, 1}, {40, 20}, FloorCell::kOccupied)
              .grid();
  has_rooms_ = false;
  const Vector2d end(1.35, -0.4);
  lead_to(bed_at(end, "bedroom"), {1.55, 2.3}, -1.75);
  (void)hear(6);
  const auto next = guidance_->next_place();
  ASSERT_TRUE(next);
  EXPECT_LT((*next - place_).norm(), 1) << "a step, to where the passage lies ahead";
  EXPECT_LT(next->x(), 1.5);
  place_ = {1.35, 2.3};
  lead_to(bed_at(end, "bedroom"), place_, -kPi / 2);
  (void)hear(6);
  EXPECT_LT(guidance_->next_place().value().y(), 1) << "from where all of it lies ahead";
}

TEST_F(GuidanceTest, StepsThatAreToBeWalkedAreRatherTooFewThanTooMany) {
  lead_to(room("kitchen"), {2.75, 3.45}, 0);  // the door is 2.6 steps ahead, the end 3.9
  EXPECT_THAT(hear(7), ElementsAre("To the kitchen: about 4 steps.", "The door is ahead of you.",
                                   "Straight on, 2 steps to the door."));
}

TEST_F(GuidanceTest, WhereNothingButRoomsIsKnownTheyAreTold) {
  Goal goal = bed_at({7.3, 0.8}, "kitchen");
  goal.outline.reset();
  lead_to(goal, {0.6, 3.45}, 0);
  EXPECT_THAT(hear(8), ElementsAre("I know no safe way there.",
                                   "The bed is in the kitchen, the next room."));
  EXPECT_EQ(guidance_->state(), State::kByRooms);
}

TEST_F(GuidanceTest, AWayThatWasNotFoundOnceIsLookedForAgain) {
  room_ = "bedroom";
  lead_to(room("kitchen"), {-3, 3.45}, 0);  // a wrong place, off the floor
  EXPECT_THAT(hear(20), ElementsAre("I know no safe way there.", "The kitchen is the next room."));
  EXPECT_EQ(guidance_->state(), State::kByRooms);
  place_ = {1, 3.45};
  EXPECT_THAT(hear(14), ElementsAre("To the kitchen: about 7 steps.", "The door is ahead of you.",
                                    "Straight on, 6 steps to the door."));
}

TEST_F(GuidanceTest, WhereNoSafeWayIsKnownItLeadsNearAndTellsTheRest) {
  grid_ = testing::two_rooms().fill({19, 1}, {40, 39}, FloorCell::kUnknown).grid();
  lead_to(bed_at({3.5, 3.4}, "bedroom"), {0.6, 3.45}, 0);
  EXPECT_THAT(hear(9), ElementsAre("I know no safe way there.", "I bring you as near as I know.",
                                   "Straight on, 2 steps."));
  std::vector<std::string> said;
  while (said.empty()) said = hear(0.2, 0.5);
  (void)hear(1, 0.2);
  EXPECT_THAT(hear(9),
              ElementsAre("I know the way no further.", "The bed is at 12 o'clock, 1 step."));
  EXPECT_EQ(guidance_->state(), State::kNearest);
}

TEST_F(GuidanceTest, WhatIsLeftIsProbablyThereWhereThePlaceOrTheGoalIsNotSure) {
  grid_ = testing::two_rooms().fill({19, 1}, {40, 39}, FloorCell::kUnknown).grid();
  Goal bed = bed_at({3.5, 3.4}, "bedroom");
  for (const bool is_place : {true, false}) {
    bed.is_sure = is_place;
    sigma_m_ = is_place ? 0.45 : 0.02;
    lead_to(bed, {1.6, 3.45}, 0);
    const auto said = go(12);
    const auto left = std::ranges::find(said, "where.direction_probable", &Prompt::message_id);
    ASSERT_NE(left, said.end()) << ::testing::PrintToString(texts(said));
    EXPECT_THAT(left->text, StartsWith("The bed is probably at 12 o'clock, "));
    EXPECT_EQ(left->confidence, Confidence::kProbable);
  }
}

TEST_F(GuidanceTest, WhatStandsBetweenTheWaysEndAndTheGoalIsSaid) {
  grid_ = testing::two_rooms().fill({19, 1}, {40, 39}, FloorCell::kUnknown).grid();
  KnownThing& shelf = things_.emplace_back();
  shelf.name = "bookcase";
  shelf.probability = 0.99;
  shelf.position_plan = Eigen::Vector3d(2.4, 3.4, 1);
  shelf.box_keyframe.size_m = {0.3, 1, 2};
  lead_to(bed_at({3.5, 3.4}, "bedroom"), {1.7, 3.45}, 0);
  std::vector<std::string> said;
  for (int i = 0; i < 60; ++i) {
    for (const std::string& text : hear(0.5)) said.push_back(text);
  }
  EXPECT_EQ(said.back(), "The bookcase is in between.") << ::testing::PrintToString(said);
}

// A hand, a sleeve, or a bag before it.
TEST_F(GuidanceTest, ACameraThatIsCoveredForFiveSecondsIsToldAndTheWayGoesOn) {
  lead_to(bed_at({7.3, 0.8}, "kitchen"), {0.6, 3.45}, 0);
  (void)hear(8);
  (void)hear(1, 0.6);
  is_seen_ = false;
  const auto covered = hear(5, 0.3);
  EXPECT_THAT(covered, ElementsAre("I lost where you are. Stop and wait."));
  is_seen_ = true;
  EXPECT_THAT(hear(6), ElementsAre(StartsWith("Straight on"))) << "at once: they stand";
  EXPECT_NE(guidance_->state(), State::kLost);
}

TEST_F(GuidanceTest, PausesRepeatsAndEndsByRequest) {
  lead_to(room("kitchen"), {1, 3.45}, 0);
  (void)hear(7);
  EXPECT_EQ(ask(GuidanceRequest::kHowFar), "7 steps to the kitchen.");
  EXPECT_EQ(ask(GuidanceRequest::kNext), "In 6 steps: through the door.");
  EXPECT_EQ(ask(GuidanceRequest::kRepeat), "Straight on, 6 steps to the door.");
  EXPECT_EQ(ask(GuidanceRequest::kPause), "Paused.");
  EXPECT_THAT(hear(30, 0.05), IsEmpty());
  EXPECT_EQ(ask(GuidanceRequest::kResume), "Going on.");
  EXPECT_THAT(hear(4), ElementsAre(StartsWith("Straight on, ")));
  EXPECT_EQ(ask(GuidanceRequest::kEnd), "Guidance has ended.");
  EXPECT_THAT(hear(30, 0.3), IsEmpty());
  EXPECT_EQ(ask(GuidanceRequest::kRepeat), "I am not guiding you anywhere.");
}

TEST_F(GuidanceTest, WhatSomebodyFindsInTheWayIsGoneAround) {
  lead_to(bed_at({3.3, 3.3}, "bedroom"), {0.6, 0.6}, kPi / 4);
  (void)hear(8);
  (void)hear(1, 0.6);
  (void)hear(1);
  EXPECT_THAT(ask(GuidanceRequest::kBlocked), AnyOf(StartsWith("Turn to"), StartsWith("A little")));
  // The door is the only way.
  lead_to(room("kitchen"), {3.6, 3.45}, 0);
  (void)hear(8);
  EXPECT_THAT(ask(GuidanceRequest::kBlocked), StartsWith("Try a little to the "));
}

TEST_F(GuidanceTest, WhoIsBarredUnseenWaitsAndIsLedAroundItWhenTheyAreSeenAgain) {
  walk_until_barred_unseen();
  is_seen_ = true;
  const auto said = hear(5);
  ASSERT_FALSE(said.empty());
  EXPECT_THAT(said[0], AnyOf(StartsWith("Turn to"), StartsWith("A little")));
}

TEST_F(GuidanceTest, WhoIsBarredUnseenWhereNoFloorIsKnownIsLedByRooms) {
  guidance_.emplace(HomeMap{nullptr, &layout_, layout_.doorways()}, room("kitchen"), wording_);
  place_ = {1, 3.45};
  (void)hear(6);
  ASSERT_EQ(guidance_->state(), State::kByRooms);
  is_seen_ = false;
  (void)hear(2);
  EXPECT_EQ(ask(GuidanceRequest::kBlocked), "I lost where you are. Stop and wait.");
  (void)hear(3);
  is_seen_ = true;
  EXPECT_THAT(hear(6), ElementsAre("I know no safe way there.", "The kitchen is the next room."));
}

TEST_F(GuidanceTest, WhoAsksUnseenForLongIsToldToTurn) {
  lead_to(room("kitchen"), {1, 3.45}, kPi);
  (void)hear(9);
  is_seen_ = false;
  (void)hear(2);
  EXPECT_EQ(ask(GuidanceRequest::kRepeat), "I lost where you are. Stop and wait.");
  (void)hear(20);
  EXPECT_EQ(ask(GuidanceRequest::kRepeat), "I do not know where you stand. Turn slowly.");
}

TEST_F(GuidanceTest, WhatBarredThemBeforeIsForgottenOnceTheyAreLedOn) {
  walk_until_barred_unseen();
  (void)ask(GuidanceRequest::kPause);
  is_seen_ = true;
  (void)ask(GuidanceRequest::kResume);
  (void)hear(5);
  (void)hear(0.4, 0.6);
  is_seen_ = false;
  EXPECT_THAT(hear(6, 0.3), ::testing::Contains("I lost where you are. Stop and wait."));
  const auto route = guidance_->plan().route;
  is_seen_ = true;
  const auto said = hear(6);
  ASSERT_FALSE(said.empty());
  for (const std::string& text : said) EXPECT_NE(text, "I know no way around it.");
  EXPECT_LT(length_m(guidance_->plan().route), 1.2 * (route.back() - place_).norm())
      << "no detour around free floor";
}

TEST_F(GuidanceTest, WhoAsksOnceTheyAreThereHearsThatAndIsNotAskedToTurn) {
  lead_to(room("kitchen"), {1, 3.45}, 0);
  (void)hear(7);
  (void)hear(8, 0.6);
  ASSERT_EQ(guidance_->state(), State::kArrived);
  for (const GuidanceRequest request :
       {GuidanceRequest::kHowFar, GuidanceRequest::kNext, GuidanceRequest::kBlocked}) {
    EXPECT_EQ(ask(request), "You are there, in the kitchen.");
  }
}

TEST_F(GuidanceTest, WhoDidNotHearTheEndHearsItAgainThoughNobodySeesThem) {
  lead_to(room("kitchen"), {1, 3.45}, 0);
  (void)hear(7);
  (void)hear(8, 0.6);
  ASSERT_EQ(guidance_->state(), State::kArrived);
  is_seen_ = false;
  (void)hear(25);
  EXPECT_EQ(ask(GuidanceRequest::kRepeat), "Earlier: You are there, in the kitchen.");
  EXPECT_EQ(guidance_->state(), State::kArrived);
}

TEST_F(GuidanceTest, WhatIsNextIsWhatToDoUnlessTheyWalkALeg) {
  lead_to(room("kitchen"), {1, 3.45}, kPi);
  (void)hear(9);
  ASSERT_EQ(guidance_->state(), State::kTurning);
  EXPECT_EQ(ask(GuidanceRequest::kNext), "Turn around.") << "not what comes after the leg";
  (void)hear(2, 0, kPi / 2);
  (void)hear(4);
  ASSERT_EQ(guidance_->state(), State::kWalking);
  EXPECT_EQ(ask(GuidanceRequest::kNext), "In 6 steps: through the door.");
  obstacle_m_ = 0.6;
  EXPECT_THAT(hear(1, 0.4), ::testing::Contains(StartsWith("Stop.")));
  ASSERT_EQ(guidance_->state(), State::kStopped);
  EXPECT_THAT(ask(GuidanceRequest::kNext), Not(HasSubstr("through the door")));
}

TEST_F(GuidanceTest, AskingUnseenDoesNotEndAPause) {
  lead_to(room("kitchen"), {1, 3.45}, 0);
  (void)hear(8);
  (void)ask(GuidanceRequest::kPause);
  is_seen_ = false;
  (void)hear(2);
  (void)ask(GuidanceRequest::kHowFar);
  EXPECT_EQ(guidance_->state(), State::kPaused);
}

// In a corridor of 1.3 m nobody would pass a body in its midst.
TEST_F(GuidanceTest, WhatIsInTheWayIsAsBroadAsAHandWhereNoWayWereLeftElse) {
  grid_ = testing::Floor(100, 15).grid();
  has_rooms_ = false;
  Goal spot;
  spot.kind = Goal::Kind::kSpot;
  spot.noun = {Noun::Kind::kThing, "spot"};
  spot.outline = Outline{{8, 0.75}};
  lead_to(spot, {2, 0.75}, 0);
  (void)hear(8);
  EXPECT_THAT(ask(GuidanceRequest::kBlocked), AnyOf(StartsWith("Turn to"), StartsWith("A little")));
}

TEST_F(GuidanceTest, WhoComesNoFurtherIsToldTheRestAndNotSentAgain) {
  lead_to(room("kitchen"), {3.4, 3.45}, 0);
  (void)hear(8);
  for (int i = 0; i < 4; ++i) {
    EXPECT_THAT(ask(GuidanceRequest::kBlocked), StartsWith("Try a little to the "));
    EXPECT_THAT(hear(4), IsEmpty()) << "until they have tried";
  }
  EXPECT_EQ(ask(GuidanceRequest::kBlocked), "I know the way no further.");
  EXPECT_THAT(hear(10), ElementsAre("Something is in the way here. Ask again later.",
                                    "The kitchen is the next room."));
  EXPECT_EQ(guidance_->state(), State::kNearest);
  (void)ask(GuidanceRequest::kRepeat);
  EXPECT_THAT(hear(4), ElementsAre("Something is in the way here. Ask again later."));
  place_.x() = 2;
  (void)hear(4);
  (void)ask(GuidanceRequest::kRepeat);
  EXPECT_THAT(hear(10), Not(::testing::Contains(HasSubstr("in the way here")))) << "not elsewhere";
}

// There is always another way, but they do not find it.
TEST_F(GuidanceTest, WhoComesNoFurtherOnWaysAroundIsToldTheRest) {
  grid_ = testing::Floor(140, 60).grid();
  has_rooms_ = false;
  lead_to(bed_at({12, 3}, "hall"), {3, 3}, 0);
  (void)hear(8);
  for (int i = 0; i < 4; ++i) {
    EXPECT_THAT(ask(GuidanceRequest::kBlocked), Not(HasSubstr("no further")));
    (void)hear(4);
  }
  EXPECT_EQ(ask(GuidanceRequest::kBlocked), "I know the way no further.");
}

// In its frame, where what bars the door leaves no more of the room than the way's end.
TEST_F(GuidanceTest, WhoIsBarredByTheRoomsDoorIsNotToldToBeThere) {
  grid_ = testing::two_rooms().fill({43, 28}, {60, 40}, FloorCell::kOccupied).grid();
  lead_to(room("kitchen"), {3.6, 3.45}, 0);
  std::vector<std::string> said = hear(8);
  for (int i = 0; i < 6 && !guidance_->is_over(); ++i) {
    place_.x() = 3.95;
    (void)hear(2);
    said.push_back(ask(GuidanceRequest::kBlocked));
    for (const std::string& text : hear(4)) said.push_back(text);
  }
  EXPECT_EQ(guidance_->state(), State::kNearest) << ::testing::PrintToString(said);
  EXPECT_THAT(said, Not(::testing::Contains(StartsWith("You are there"))));
}

TEST_F(GuidanceTest, LessThanHalfAStepIsASmallOne) {
  Goal spot;
  spot.kind = Goal::Kind::kSpot;
  spot.noun = {Noun::Kind::kThing, "spot"};
  spot.outline = Outline{{2, 1}};
  lead_to(spot, {1.6, 1.05}, 0);
  EXPECT_EQ(hear(9).back(), "One small step straight on.");
}

TEST_F(GuidanceTest, AskingChangesNothingOfTheWay) {
  lead_to(bed_at({7.2, 0.8}, "kitchen"), {0.6, 3.45}, 0);
  (void)hear(8);
  while (guidance_->state() == State::kWalking && place_.x() < 7) {
    (void)hear(0.2, 0.6);
    (void)ask(GuidanceRequest::kHowFar);
    (void)ask(GuidanceRequest::kNext);
    now_ns_ += 5 * kSecond;
  }
  EXPECT_THAT(guidance_->state(), AnyOf(State::kCorner, State::kStopped, State::kTurning));
}

// Somebody who walks, turns, stands, is lost and asks as it comes: whatever happens, the rules
// hold.
TEST_F(GuidanceTest, RulesHoldForAnythingThatHappens) {
  std::map<std::string, int> heard;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    RandomStream random(seed);
    lead_to(random.uniform() < 0.5 ? room("kitchen") : bed_at({7.3, 0.8}, "kitchen"),
            {random.between(0.5, 3.5), random.between(0.5, 3.5)}, random.between(-kPi, kPi));
    TimestampNs silent_from_ns = 0, seen_ns = now_ns_;
    double speed = 0, turning = 0;
    for (int tick = 0; tick < 600 && !guidance_->is_over(); ++tick) {
      now_ns_ += kTick;
      if (random.uniform() < 0.05) speed = random.uniform() < 0.4 ? 0 : random.between(0.2, 0.8);
      if (random.uniform() < 0.05) turning = random.uniform() < 0.5 ? 0 : random.between(-1, 1);
      if (random.uniform() < 0.02) is_seen_ = random.uniform() < 0.7;
      room_ = is_seen_ || random.uniform() < 0.5 ? layout_.room_at(place_) : std::nullopt;
      heading_rad_ += 0.2 * turning;
      const Vector2d next =
          place_ + 0.2 * speed * Vector2d(std::cos(heading_rad_), std::sin(heading_rad_));
      if (grid_.fits(next, 0.2)) place_ = next;
      if (is_seen_) seen_ns = now_ns_;
      const bool asks = random.uniform() < 0.01;
      std::optional<Prompt> prompt;
      if (asks) {
        prompt = guidance_->request(static_cast<GuidanceRequest>(random.index(7)), now_ns_);
      } else {
        prompt = guidance_->update(walker());
      }
      if (!prompt) continue;
      ++heard[prompt->message_id];
      SCOPED_TRACE(fmt::format("seed {}, {} s: {}", seed, tick / 5, prompt->text));
      // One at a time, and each may be begun.
      const bool breaks_off = prompt->priority == Priority::kHazard;
      EXPECT_TRUE(asks || breaks_off || now_ns_ >= silent_from_ns);
      EXPECT_GE(prompt->valid_until_ns, now_ns_);
      silent_from_ns = now_ns_ + static_cast<TimestampNs>(speaking_s(prompt->text) * 1e9);
      // Never a direction of one whose place is not known; but a step after a turn from where it
      // was, which sounds unsure.
      const bool is_unseen_step =
          prompt->message_id == "guide.walk" && prompt->confidence == Confidence::kProbable;
      const bool is_direction = prompt->message_id.starts_with("guide.turn") ||
                                prompt->message_id.starts_with("guide.little") ||
                                prompt->message_id.starts_with("guide.walk") ||
                                prompt->message_id.starts_with("guide.soon") ||
                                prompt->message_id.starts_with("guide.place");
      EXPECT_TRUE(!is_direction || is_unseen_step || seconds_between(seen_ns, now_ns_) < 1.5);
      // Never two turns in one sentence.
      std::size_t turns = 0;
      for (std::size_t at = 0; (at = prompt->text.find("urn", at)) != std::string::npos; ++at)
        ++turns;
      EXPECT_LE(turns, 1u);
      EXPECT_TRUE(guidance_->state() != State::kArrived || layout_.room_at(place_) == "kitchen");
    }
    is_seen_ = true;
    room_.reset();
  }
  // All of it happened.
  for (const char* message : {"guide.begin", "guide.turn_around", "guide.turn_left",
                              "guide.walk_to", "guide.off", "guide.lost_wait", "guide.found",
                              "guide.stop", "guide.paused", "guide.little_left", "guide.ended"}) {
    EXPECT_GT(heard[message], 0) << message;
  }
}

TEST(TurnPhraseTest, NamesTheSideOfAnHour) {
  EXPECT_EQ(turn_phrase(kPi / 3).message_id, "guide.turn_hour_left");
  EXPECT_EQ(turn_phrase(-kPi / 3).message_id, "guide.turn_hour_right");
}

TEST(GuidanceOptionsTest, SayWhatIsWrong) {
  EXPECT_OK(GuidanceOptions{}.validate());
  GuidanceOptions options;
  options.announce_from_m = 1;
  EXPECT_ERROR(options.validate(), "announce_from_m is 1");
  options = {};
  options.remind_s = 0;
  EXPECT_ERROR(options.validate(), "remind_s is 0");
}

}  // namespace
}  // namespace roomwise::guide
