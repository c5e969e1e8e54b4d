#include "laboratory/trials/guidance/guidance_trial.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>
#include <set>

#include "laboratory/simulation/home/home_geometry.h"
#include "laboratory/simulation/testing/test_homes.h"
#include "laboratory/trials/guidance/guidance_page.h"
#include "laboratory/trials/guidance/hindrance.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::trials {
namespace {

using Kind = Instruction::Kind;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

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
  const HomeOfWalk same_ = [this](std::size_t) -> const WalkedHome& { return home_; };
  std::optional<GuidedMap> map_;
};

TEST_F(GuidanceTrialTest, TheMapHasRoomsDoorAndThings) {
  EXPECT_EQ(map_->layout.rooms().size(), 2u);
  ASSERT_EQ(map_->layout.doorways().size(), 1u);
  EXPECT_NEAR(map_->layout.doorways()[0].middle_plan.x(), 4.06, 0.2);
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

TEST(TrialSummaryTest, OfThoseWhoDidNotArriveThereIsNoPath) {
  std::vector<GuidedWalk> walks(2);
  const TrialSummary none = summarise(walks);
  for (const auto& figure :
       {none.path_ratio, none.path_ratio_deviation, none.mean_s, none.median_to_goal_m,
        none.median_position_error_m, none.p95_heading_error_rad, none.prompts_per_m}) {
    EXPECT_FALSE(figure) << *figure;
  }
  walks[0].says_there = walks[0].is_there = true;
  walks[0].goal.shortest_m = walks[0].walked_m = 3;
  EXPECT_EQ(summarise(walks).path_ratio, 1);
  EXPECT_EQ(summarise(walks).prompts_per_m, 0);
}

TEST_F(GuidanceTrialTest, EachHomeHasPeopleOfItsOwnWhoeverLeadsThem) {
  TrialOptions options;
  options.seed = 1;
  std::set<std::uint64_t> seeds;
  for (options.home_seed = 221; options.home_seed < 231; ++options.home_seed) {
    for (std::uint64_t walk = 0; walk < 20; ++walk) seeds.insert(seed_of_walk(options, walk));
  }
  EXPECT_EQ(seeds.size(), 200u);
  const std::uint64_t led = seed_of_walk(options, 3);
  options.guide = Guide::kList;
  EXPECT_EQ(seed_of_walk(options, 3), led) << "walks of two guides are compared in pairs";
  options.goals.goals = 4;
  options.guide = Guide::kSession;
  const auto here = walks(options);
  ++options.home_seed;
  EXPECT_NE(walks(options)[0].walked_m, here[0].walked_m);
}

TEST_F(GuidanceTrialTest, ThePageShowsEachWalkWithWhatWasHeard) {
  TrialOptions options;
  options.goals.goals = 2;
  const auto all = walks(options);
  const std::string page = guidance_page(all, same_, "Walks", "modelled");
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
  EXPECT_THAT(walker.contacts(), IsEmpty());
}

// ---- whose fault it is that something is touched ----

// A table without legs, over which no cane comes.
simulation::PlacedObject table_top(const std::string& name, const Eigen::Vector2d& middle,
                                   const Eigen::Vector2d& size_m) {
  simulation::PlacedObject table = simulation::box_object({middle.x(), middle.y(), 0.75});
  table.name = name;
  table.size_m << size_m, 0.05;
  return table;
}

// Says what it is told to say, when it is told to.
class ScriptedLeader final : public Leader {
 public:
  struct Word {
    double at_s;
    std::string message_id;
    guide::Values values = {};
  };
  explicit ScriptedLeader(std::vector<Word> words) : words_(std::move(words)) {}

  [[nodiscard]] Expected<std::vector<guide::Prompt>> after_step(double now_s,
                                                                const SimulatedWalker&) override {
    std::vector<guide::Prompt> prompts;
    for (; said_ < words_.size() && words_[said_].at_s <= now_s; ++said_) {
      prompts.push_back(make_prompt(wording_, "guide", words_[said_].message_id,
                                    words_[said_].values, guide::Confidence::kSure,
                                    trial_ns(now_s + 2)));
    }
    return prompts;
  }
  [[nodiscard]] Expected<std::vector<guide::Prompt>> request(guide::GuidanceRequest,
                                                             double) override {
    return std::vector<guide::Prompt>();
  }
  [[nodiscard]] bool knows_goal() const override { return true; }
  [[nodiscard]] bool is_over() const override { return said_ == words_.size(); }
  [[nodiscard]] bool says_there() const override { return false; }
  [[nodiscard]] std::optional<Eigen::Vector2d> next_place(const SimulatedWalker&) const override {
    return std::nullopt;
  }
  [[nodiscard]] const Sightings& sightings() const override { return sightings_; }

 private:
  std::vector<Word> words_;
  std::size_t said_ = 0;
  guide::MessageCatalogue catalogue_ = guide::MessageCatalogue::built_in();
  guide::Wording wording_{&catalogue_, {}};
  Sightings sightings_;
};

class ContactTest : public ::testing::Test {
 protected:
  // From the left wall's middle, facing the tables.
  [[nodiscard]] GuidedWalk walk(std::vector<ScriptedLeader::Word> words) const {
    ScriptedLeader leader(std::move(words));
    GuidedGoal goal;
    goal.room = 0;
    goal.start = {0.5, 2};
    goal.shortest_m = 3;
    return lead_by(leader, home_, goal, options_, 0);
  }
  void put(const simulation::PlacedObject& table) {
    model_.objects.push_back(table);
    home_ = WalkedHome(model_);
  }

  simulation::HomeModel model_ = simulation::square_rooms(1);
  WalkedHome home_{model_};
  const HomeOfWalk same_ = [this](std::size_t) -> const WalkedHome& { return home_; };
  TrialOptions options_{.max_s = 30};
};

TEST_F(ContactTest, APromptCausedWhatItLeadsStraightInto) {
  put(table_top("table", {2.5, 2}, {1, 2}));
  const GuidedWalk led = walk({{0, "guide.walk", {{"distance", "4 steps"}}}});
  ASSERT_EQ(led.contacts.size(), 1u);
  EXPECT_EQ(led.contacts[0].thing, "table");
  EXPECT_EQ(led.contacts[0].prompt, 0u);
  EXPECT_TRUE(led.contacts[0].is_by_prompt);
  EXPECT_LT(led.contacts[0].place.x(), 2);
  EXPECT_EQ(summarise(std::span(&led, 1)).contacts_by_prompt, 1u);
  const std::string page = guidance_page(std::span(&led, 1), same_, "Walks", "scripted");
  EXPECT_THAT(page, HasSubstr("1 contacts, 1 of them by prompts"));
  EXPECT_THAT(page, HasSubstr("Touched: table"));
  EXPECT_THAT(page, HasSubstr("by prompt 1"));
}

TEST_F(ContactTest, WhoVeersIntoWhatTheyWereLedPastDidItThemselves) {
  put(table_top("left table", {2.5, 3}, {2, 1.2}));
  put(table_top("right table", {2.5, 1}, {2, 1.2}));
  const std::vector<ScriptedLeader::Word> words{{0, "guide.walk", {{"distance", "4 steps"}}}};
  options_.faults = {.veer_degrees_per_m = 30, .wrong_share = 0};
  for (options_.seed = 0; walk(words).contacts.empty() && options_.seed < 50;) ++options_.seed;
  const GuidedWalk led = walk(words);
  ASSERT_EQ(led.contacts.size(), 1u);
  EXPECT_THAT(led.contacts[0].thing, HasSubstr(" table"));
  EXPECT_EQ(led.contacts[0].prompt, 0u);
  EXPECT_FALSE(led.contacts[0].is_by_prompt);
  EXPECT_EQ(summarise(std::span(&led, 1)).contacts_by_prompt, 0u);
  EXPECT_THAT(guidance_page(std::span(&led, 1), same_, "Walks", "scripted"),
              HasSubstr("the walker&#39;s own"));
  options_.faults.scale = 0;
  EXPECT_THAT(walk(words).contacts, IsEmpty());
}

// With steps as they are counted they would stand before it.
TEST_F(ContactTest, WhoWalksFartherThanTheyWereToldDidItThemselves) {
  put(table_top("table", {2.1, 2}, {1, 2}));
  options_.faults = {.step_share = 0.8, .wrong_share = 0};
  const std::vector<ScriptedLeader::Word> words{{0, "guide.walk", {{"distance", "1 step"}}}};
  for (options_.seed = 0; walk(words).contacts.empty() && options_.seed < 50;) ++options_.seed;
  const GuidedWalk led = walk(words);
  ASSERT_EQ(led.contacts.size(), 1u);
  EXPECT_FALSE(led.contacts[0].is_by_prompt);
}

// What was heard before the contact, and not yet done, did not lead there, nor help.
TEST_F(ContactTest, ItCountsWhatIsDoneAndNotWhatWasJustHeard) {
  put(table_top("table", {2.5, 2}, {1, 2}));
  options_.faults = {.scale = 0, .min_reaction_s = 1.5, .max_reaction_s = 1.5};
  const std::vector<ScriptedLeader::Word> walk_on{{0, "guide.walk", {{"distance", "4 steps"}}}};
  const double touched_s = walk(walk_on).contacts.at(0).at_s;
  auto words = walk_on;
  words.push_back({touched_s - 1.5, "guide.stop"});
  const GuidedWalk led = walk(words);
  ASSERT_EQ(led.contacts.size(), 1u);
  ASSERT_EQ(led.heard.size(), 2u);
  EXPECT_EQ(led.contacts[0].prompt, 0u);
  EXPECT_TRUE(led.contacts[0].is_by_prompt);
}

TEST_F(ContactTest, AListIsDoneExactlyAsAWhole) {
  put(table_top("table", {3, 3.2}, {2, 0.6}));
  WalkerFaults exact{.scale = 0};
  SimulatedWalker walker(home_, {0.5, 2}, 0, exact, 1);
  ContactJudge judge(home_);
  walker.hear_list(
      {{Kind::kWalk, 0, 2}, {Kind::kTurn, std::numbers::pi / 2, 0}, {Kind::kWalk, 0, 1}});
  judge.hear(walker, 3);
  for (int i = 0; i < 300; ++i) {
    walker.step(kWalkerStep_s);
    judge.step(i * kWalkerStep_s, walker);
  }
  const std::vector<Contact> contacts = judge.finish();
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_EQ(contacts[0].prompt, 3u);
  EXPECT_TRUE(contacts[0].is_by_prompt);
}

TEST_F(GuidanceTrialTest, WhatIsTouchedHasAName) {
  EXPECT_EQ(home_.nearest_thing({6.6, 3.2}), "box");
  EXPECT_EQ(home_.nearest_thing({4.06, 1.65}), "frame of the door between the hall and the study");
  EXPECT_EQ(home_.nearest_thing({0.1, 1}), "left wall of the hall");
  EXPECT_EQ(home_.nearest_thing({3.9, 0.5}), "right wall of the hall");
  EXPECT_EQ(home_.nearest_thing({2, 0.1}), "lower wall of the hall");
  EXPECT_EQ(home_.nearest_thing({6, 3.9}), "upper wall of the study");
}

// ---- what is in the way ----

class HindranceTest : public GuidanceTrialTest {
 protected:
  [[nodiscard]] std::vector<WalkGround> hindered(Hindrance hindrance,
                                                 const WalkedHome& home) const {
    const auto goals = choose_goals(*map_, home, options_.goals);
    EXPECT_OK(goals);
    return hinder(*map_, std::make_shared<const WalkedHome>(home), *goals, hindrance, options_);
  }
  [[nodiscard]] static const simulation::PlacedObject* person_in(const WalkedHome& home) {
    const auto& objects = home.model.objects;
    const auto found = std::ranges::find(objects, "person", &simulation::PlacedObject::name);
    return found == objects.end() ? nullptr : &*found;
  }

  TrialOptions options_{.position = {.wrong_share = 0, .has_depth = true}};
};

TEST_F(HindranceTest, HasANameOrIsNone) {
  EXPECT_EQ(parse_hindrance("person"), Hindrance::kPerson);
  EXPECT_EQ(parse_hindrance("person-goes"), Hindrance::kPersonGoes);
  EXPECT_EQ(parse_hindrance("closed-door"), Hindrance::kClosedDoor);
  EXPECT_FALSE(parse_hindrance("day"));
}

TEST_F(HindranceTest, WithoutOneAllIsAsItWas) {
  for (const WalkGround& ground : hindered(Hindrance::kNone, home_)) {
    EXPECT_FALSE(ground.goal.is_hindered);
    EXPECT_EQ(person_in(*ground.home), nullptr);
  }
}

TEST_F(HindranceTest, SomebodyStandsOnTheWayAndTheWalkGoesRoundThem) {
  options_.faults.scale = 0;
  std::size_t seen = 0, arrived = 0;
  const auto grounds = hindered(Hindrance::kPerson, home_);
  for (std::size_t i = 0; i < grounds.size(); ++i) {
    const WalkedHome* const home = grounds[i].home.get();
    const GuidedGoal& goal = grounds[i].goal;
    if (!goal.is_hindered || !goal.is_reachable) continue;
    ++seen;
    const simulation::PlacedObject* const person = person_in(*home);
    ASSERT_NE(person, nullptr);
    const Eigen::Vector2d place = person->world_from_object.translation.head<2>();
    EXPECT_GE((place - goal.start).norm(), 0.9) << "straight on a metre of way is less";
    EXPECT_EQ(home->nearest_thing(place), "person");
    EXPECT_EQ(map_->floor.at(place), fusion::FloorCell::kFree);
    arrived += lead(*map_, *home, goal, options_, i).arrived() ? 1 : 0;
  }
  EXPECT_GE(seen, 10u);
  EXPECT_GE(arrived + 2, seen);
  // The same with the same seed, elsewhere with another.
  const auto again = hindered(Hindrance::kPerson, home_);
  EXPECT_EQ(person_in(*again[0].home)->world_from_object.translation,
            person_in(*grounds[0].home)->world_from_object.translation);
}

TEST_F(HindranceTest, SomebodyWhoGoesIsWaitedFor) {
  options_.faults.scale = 0;
  const auto stay = hindered(Hindrance::kPerson, home_);
  const auto grounds = hindered(Hindrance::kPersonGoes, home_);
  std::size_t without_way = 0, arrived = 0;
  for (std::size_t i = 0; i < grounds.size(); ++i) {
    const auto& [home, goal, leaving] = grounds[i];
    if (!goal.is_hindered || stay[i].goal.is_reachable) continue;
    ++without_way;
    ASSERT_TRUE(leaving);
    EXPECT_TRUE(goal.is_reachable);
    EXPECT_EQ(person_in(*home)->world_from_object.translation,
              person_in(*stay[i].home)->world_from_object.translation);
    EXPECT_EQ(person_in(*leaving->then), nullptr);
    EXPECT_FALSE(lead(*map_, *home, goal, options_, i).arrived()) << "while they stay";
    arrived += lead(*map_, *home, goal, options_, i, leaving).arrived() ? 1 : 0;
  }
  EXPECT_GE(without_way, 1u);
  EXPECT_EQ(arrived, without_way);
}

TEST_F(HindranceTest, AShutDoorThatIsTheOnlyWayIsToldOfAndCounted) {
  simulation::HomeModel model = two_rooms();
  model.doors[0].has_leaf = true;
  const WalkedHome home(model);
  const auto grounds = hindered(Hindrance::kClosedDoor, home);
  std::vector<GuidedWalk> led;
  for (std::size_t i = 0; i < grounds.size(); ++i) {
    const GuidedGoal& goal = grounds[i].goal;
    EXPECT_EQ(goal.is_reachable, !goal.is_hindered);
    if (goal.is_hindered) led.push_back(lead(*map_, *grounds[i].home, goal, options_, i));
  }
  ASSERT_GE(led.size(), 3u);
  for (const GuidedWalk& walk : led) {
    EXPECT_FALSE(walk.arrived());
    EXPECT_TRUE(walk.is_told_not_reachable());
  }
  const TrialSummary summary = summarise(led);
  EXPECT_EQ(summary.hindered, led.size());
  EXPECT_EQ(summary.without_way, led.size());
  EXPECT_EQ(summary.not_reachable, led.size());
  EXPECT_EQ(summary.arrived, 0u);
  EXPECT_EQ(summary.arrived_hindered, 0u);
  std::vector<GuidedWalk> around(3);
  for (GuidedWalk& walk : around) walk.says_there = walk.is_there = true;
  around[0].goal.is_hindered = around[1].goal.is_hindered = true;
  around[1].goal.is_reachable = false;  // squeezed through
  EXPECT_EQ(summarise(around).arrived_hindered, 1u) << "nothing was in the way of the third";
}

TEST_F(HindranceTest, WhoGivesUpWasToldNothing) {
  GuidedWalk walk;
  walk.goal.is_hindered = true;
  walk.goal.is_reachable = false;
  EXPECT_FALSE(walk.is_told_not_reachable());
  walk.has_ended = true;
  EXPECT_TRUE(walk.is_told_not_reachable());
  walk.says_there = true;
  EXPECT_FALSE(walk.is_told_not_reachable());
}

TEST_F(HindranceTest, PeopleAreDrawnAsBroadAsTheyAre) {
  const auto load = with_people(simulation::load_box);
  const auto body = load("person");
  ASSERT_OK(body);
  Eigen::AlignedBox3f bounds;
  for (const Eigen::Vector3f& place : body->positions) bounds.extend(place);
  EXPECT_TRUE(bounds.sizes().isApprox(Eigen::Vector3f(0.5F, 0.3F, 1.7F), 1e-3F));
  for (const auto& triangle : body->triangles) {
    const auto at = [&](int i) { return body->positions[triangle.corners[i]]; };
    const Eigen::Vector3f outward = (at(1) - at(0)).cross(at(2) - at(0));
    EXPECT_GT(outward.dot(body->normals[triangle.corners[0]]), 0);
  }
  EXPECT_OK(load("box"));
  EXPECT_ERROR(load("bed"), "no model 'bed'");
}

TEST(WalkerFaultsTest, SayWhatIsWrong) {
  EXPECT_OK(WalkerFaults{}.validate());
  EXPECT_ERROR(WalkerFaults{.scale = -1}.validate(), "scale is -1");
  EXPECT_ERROR(PositionModel{.answered_share = 0}.validate(), "answered_share is 0");
}

}  // namespace
}  // namespace roomwise::trials
