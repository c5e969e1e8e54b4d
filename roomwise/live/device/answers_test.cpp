#include "roomwise/live/device/answers.h"

#include <gmock/gmock.h>

#include "roomwise/guide/testing/drawn_floor.h"

namespace roomwise::live {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

FrameResult glance_in(const std::string& room, double t_ms, rooms::Verdict verdict) {
  FrameResult result;
  result.t_ms = t_ms;
  result.decision.emplace();
  result.decision->verdict = verdict;
  result.decision->rooms = {{room, 0.99}, {"hall", 0.01}};
  return result;
}

guide::KnownThing thing(const std::string& name, const std::string& room,
                        const Eigen::Vector3d& position_plan) {
  guide::KnownThing thing;
  thing.name = name;
  thing.probability = 0.99;
  thing.room = room;
  thing.position_plan = position_plan;
  thing.box_keyframe.size_m = {0.5, 0.5, 0.5};
  return thing;
}

// A camera at the origin, 1.3 m up, that looks along x.
CameraPose at_the_origin() {
  Eigen::Matrix3d plan_from_camera;
  plan_from_camera << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  CameraPose place;
  place.plan_from_camera = {Eigen::Quaterniond(plan_from_camera), {0, 0, 1.3}};
  place.sigma_m = 0.03;
  place.room = "kitchen";
  return place;
}

class CallerTest : public ::testing::Test {
 protected:
  std::vector<guide::Prompt> after(const FrameResult& result) {
    return caller.after({home, &result, settings, result.t_ms});
  }

  HomeView home;
  service::SpeakingSettings settings;
  Announcer caller;
};

TEST_F(CallerTest, CallsARoomOutOnceTwoLooksAgree) {
  const auto kitchen = [](double t) { return glance_in("kitchen", t, rooms::Verdict::kRoom); };
  EXPECT_THAT(after(kitchen(0)), SizeIs(0));
  const auto called = after(kitchen(100));
  ASSERT_THAT(called, SizeIs(1));
  EXPECT_EQ(called[0].priority, guide::Priority::kCallout);
  EXPECT_EQ(called[0].text, "Now in the kitchen.");
  EXPECT_EQ(called[0].valid_until_ns, 100'000'000 + 3'000'000'000LL);
  EXPECT_THAT(after(kitchen(200)), SizeIs(0));
}

TEST_F(CallerTest, ARoomThatIsNotSureEnoughAtFirstIsCalledOutOnceItIs) {
  for (const double probability : {0.85, 0.85, 0.99}) {
    FrameResult result = glance_in("kitchen", 0, rooms::Verdict::kRoom);
    result.decision->rooms[0].score = probability;
    EXPECT_THAT(after(result), SizeIs(probability > 0.9 ? 1 : 0)) << probability;
  }
}

TEST_F(CallerTest, ARoomThatAnAnswerNamedIsNotCalledOut) {
  const auto in = [](const char* room, double t) {
    return glance_in(room, t, rooms::Verdict::kRoom);
  };
  EXPECT_THAT(after(in("kitchen", 0)), SizeIs(0));
  const FrameResult asked = in("kitchen", 100);
  const Situation now{home, &asked, settings, 100};
  guide::Prompt named;
  named.message_id = "room.is";
  caller.answered(now, {named});
  EXPECT_THAT(after(in("kitchen", 200)), SizeIs(0));
  EXPECT_THAT(after(in("hall", 300)), SizeIs(0));
  EXPECT_THAT(after(in("hall", 400)), SizeIs(1)) << "that was not named yet";
  EXPECT_THAT(after(in("kitchen", 500)), SizeIs(0));
  EXPECT_THAT(after(in("kitchen", 600)), SizeIs(1)) << "and this one is entered anew";
}

TEST_F(CallerTest, OneLookIntoAnotherRoomIsNotCalledOut) {
  for (const double t : {0.0, 1.0}) after(glance_in("kitchen", t, rooms::Verdict::kRoom));
  EXPECT_THAT(after(glance_in("bath", 2, rooms::Verdict::kRoom)), SizeIs(0));
  EXPECT_THAT(after(glance_in("kitchen", 3, rooms::Verdict::kRoom)), SizeIs(0));
  EXPECT_THAT(after(glance_in("kitchen", 4, rooms::Verdict::kRoom)), SizeIs(0));
}

TEST_F(CallerTest, WhatIsNotSureIsNotCalledOut) {
  for (const double t : {0.0, 1.0, 2.0}) {
    EXPECT_THAT(after(glance_in("kitchen", t, rooms::Verdict::kNotSure)), SizeIs(0));
  }
}

TEST_F(CallerTest, AnObstacleIsCalledOutWithEveryPictureThatShowsIt) {
  FrameResult result = glance_in("kitchen", 0, rooms::Verdict::kNotSure);
  EXPECT_THAT(after(result), SizeIs(0));
  result.obstacle.emplace().ahead_left_m = {0.7, 0};
  const auto called = after(result);
  ASSERT_THAT(called, SizeIs(1));
  EXPECT_EQ(called[0].priority, guide::Priority::kHazard);
  EXPECT_THAT(after(result), SizeIs(1));  // one may be lost or late on the way
  result.obstacle.reset();
  EXPECT_THAT(after(result), SizeIs(0));
}

// A table of the map, 0.75 m ahead of who stands at the origin, from 0.1 m on to the left.
class CallerBesideATable : public CallerTest {
 protected:
  void SetUp() override {
    home.things = {thing("table", "kitchen", {1, 0.35, 0.25})};
    image::Image<fusion::FloorCell> cells(120, 80, fusion::FloorCell::kFree);
    for (int row = 42; row < 52; ++row) {
      for (int column = 35; column < 45; ++column) {
        cells.at(column, row) = fusion::FloorCell::kOccupied;
      }
    }
    LiveMap map;
    map.floor.emplace(Eigen::Vector2d(-1, -2), 0.05, cells);
    home.map = std::make_shared<const LiveMap>(std::move(map));
    result = glance_in("kitchen", 0, rooms::Verdict::kNotSure);
    result.place = at_the_origin();
    sees({{0.76, 0.25}, {0.76, 0.15}});
  }
  void sees(const std::vector<Eigen::Vector2d>& ahead_left_m) {
    result.obstacle = guide::nearest_ahead(ahead_left_m);
  }
  // The hazard that is told; every one is.
  std::string called(double after_ms) {
    result.t_ms += after_ms;
    const auto prompts = after(result);
    if (prompts.empty()) return "";
    EXPECT_EQ(prompts[0].priority, guide::Priority::kHazard);
    return prompts[0].text;
  }

  // What is told at last when it goes on to be seen for 2.5 s.
  std::string called_later() {
    std::string last;
    for (int picture = 0; picture < 5; ++picture) last = called(500);
    return last;
  }

  FrameResult result;
};

TEST_F(CallerBesideATable, WhatTheMapKnowsIsAHazardWithItsNameAndSide) {
  EXPECT_EQ(called(200), "Table ahead, to the left.");
  EXPECT_EQ(called(200), "Table ahead, to the left.") << "with each picture, as one may be lost";
  EXPECT_EQ(called_later(), "");
  sees({{0.76, 0.25}, {0.76, 0.15}, {0.76, 0.05}});
  EXPECT_EQ(called(200), "Table ahead.") << "at once: it is to the left no more";
}

TEST_F(CallerBesideATable, WhatTheMapDoesNotKnowHasNoName) {
  home.things.clear();
  EXPECT_EQ(called(200), "Obstacle ahead, to the left.");
}

TEST_F(CallerBesideATable, SomebodyBehindItIsToldAtOnceAndMakesItNameless) {
  EXPECT_EQ(called(200), "Table ahead, to the left.");
  EXPECT_EQ(called_later(), "");
  sees({{0.76, 0.25}, {0.76, 0.15}, {0.9, -0.1}});
  EXPECT_EQ(called(200), "Obstacle ahead.");
  EXPECT_EQ(called_later(), "");
  sees({{0.76, 0.25}, {0.76, 0.15}});
  EXPECT_EQ(called(200), "") << "they heard of it";
}

TEST_F(CallerBesideATable, WhatTheFloorShowsButNoThingExplainsHasNoName) {
  sees({{0.76, 0.25}, {0.68, -0.02}});  // a bin beside it
  EXPECT_EQ(called(200), "Obstacle ahead.");
}

TEST_F(CallerBesideATable, WhatTheFloorDoesNotShowHasNoNameThoughABoxReachesThere) {
  home.things[0].box_keyframe.size_m.x() = 1.5;
  sees({{0.3, 0.25}});
  EXPECT_EQ(called(200), "Obstacle ahead, to the left.");
}

TEST_F(CallerBesideATable, WithoutASurePlaceItMayBeAnythingElse) {
  result.place->sigma_m = 0.4;
  EXPECT_EQ(called(200), "Obstacle ahead, to the left.");
  result.place.reset();
  EXPECT_EQ(called(20'000), "Obstacle ahead, to the left.");
}

TEST_F(CallerBesideATable, WhatLiesOnItIsNotNamed) {
  home.things.push_back(thing("cup", "kitchen", {0.85, 0.2, 0.55}));
  home.things.back().box_keyframe.size_m = {0.1, 0.1, 0.1};
  home.things.push_back(thing("lamp", "kitchen", {0.7, 0.2, 2.3}));
  EXPECT_EQ(called(200), "Table ahead, to the left.");
}

TEST(Answers, TellTheWayToAThing) {
  LiveMap map;  // with a floor of 6 x 4 m that is free
  map.floor.emplace(Eigen::Vector2d(-1, -2), 0.05,
                    image::Image<fusion::FloorCell>(120, 80, fusion::FloorCell::kFree));
  HomeView home;
  home.map = std::make_shared<const LiveMap>(std::move(map));
  home.things = {thing("microwave", "kitchen", {4, 0, 1})};
  FrameResult result = glance_in("kitchen", 500, rooms::Verdict::kRoom);
  result.place = at_the_origin();
  const service::SpeakingSettings settings;
  const service::Ask ask{1, 600, service::Question::kWayTo, "microwave"};
  const auto prompts = answer(ask, {home, &result, settings, 600});
  ASSERT_THAT(prompts, SizeIs(1));
  EXPECT_THAT(prompts[0].text, ::testing::StartsWith("Straight on, then "));
  EXPECT_THAT(prompts[0].text, ::testing::EndsWith("to the microwave."));
  EXPECT_EQ(prompts[0].confidence, guide::Confidence::kSure);
  home.things[0].probability = 0.3;
  const auto doubtful = answer(ask, {home, &result, settings, 600});
  EXPECT_EQ(doubtful.at(0).confidence, guide::Confidence::kProbable);
  EXPECT_THAT(doubtful[0].text, ::testing::EndsWith("probably to the microwave."));
  EXPECT_EQ(answer({1, 600, service::Question::kWayTo, "bed"}, {home, &result, settings, 600})
                .at(0)
                .message_id,
            "where.unknown");
  result.place.reset();
  EXPECT_EQ(answer(ask, {home, &result, settings, 600}).at(0).message_id, "route.no_place");
}

TEST(Answers, ARoomThatIsAskedForAsAThingIsKnown) {
  HomeView home;
  home.rooms = {{"kitchen", "kitchen"}};
  const service::SpeakingSettings settings;
  using service::Question;
  for (const auto question : {Question::kWhereIs, Question::kWayTo, Question::kTakeMeTo}) {
    const auto told = answer({1, 0, question, "kitchen"}, {home, nullptr, settings, 0});
    service::Ask as_room{1, 0, Question::kWhereIs, "kitchen"};
    as_room.is_room = true;
    EXPECT_EQ(told.at(0).text, answer(as_room, {home, nullptr, settings, 0}).at(0).text);
    EXPECT_NE(told[0].message_id, "where.unknown");
  }
}

TEST(Answers, ARoomWithoutTheThingIsNotTheWholeHome) {
  HomeView home;
  home.things = {thing("chair", "hall", {1, 1, 1})};
  home.rooms = {{"hall", "hall"}, {"kitchen", "kitchen"}};
  const service::SpeakingSettings settings;
  using service::Question;
  for (const auto question : {Question::kWhereIs, Question::kWayTo, Question::kTakeMeTo}) {
    service::Ask chair{1, 0, question, "chair"};
    chair.in_room = "kitchen";
    EXPECT_EQ(answer(chair, {home, nullptr, settings, 0}).at(0).text,
              "I know no chair in the kitchen.");
    chair.in_room = "cellar";
    EXPECT_EQ(answer(chair, {home, nullptr, settings, 0}).at(0).message_id, "where.unknown");
    chair.subject = "unicorn";
    EXPECT_EQ(answer(chair, {home, nullptr, settings, 0}).at(0).message_id, "where.unknown");
  }
}

TEST(Answers, WithoutANewPictureItIsSaidWhetherAnyCame) {
  HomeView home;
  const service::SpeakingSettings settings;
  Situation now{home, nullptr, settings, 0};
  const service::Ask which_way{1, 0, service::Question::kWhichWay, ""};
  EXPECT_EQ(answer(which_way, now).at(0).message_id, "device.no_picture");
  now.had_pictures = true;
  EXPECT_EQ(answer(which_way, now).at(0).message_id, "device.no_new_picture");
}

TEST(Answers, TellTheDirectionOfAThingByThePlaceOnTheMap) {
  HomeView home;
  home.things = {thing("microwave", "kitchen", {0, -2, 1})};  // to the right
  FrameResult result = glance_in("kitchen", 500, rooms::Verdict::kRoom);
  result.place = at_the_origin();
  service::SpeakingSettings settings;
  const service::Ask ask{1, 600, service::Question::kWhereIs, "microwave"};
  auto prompts = answer(ask, {home, &result, settings, 600});
  ASSERT_THAT(prompts, SizeIs(1));
  EXPECT_EQ(prompts[0].text, "The microwave is at 3 o'clock, 2 metres.");
  // Two seconds after the picture, not after the question.
  EXPECT_EQ(prompts[0].valid_until_ns, 2'500'000'000LL);
  settings.distances = service::Distances::kSteps;
  prompts = answer(ask, {home, &result, settings, 600});
  EXPECT_EQ(prompts[0].text, "The microwave is at 3 o'clock, 3 steps.");
  result.place.reset();  // a phone
  prompts = answer(ask, {home, &result, settings, 600});
  EXPECT_EQ(prompts[0].text, "The microwave is in this room.");
}

TEST(Answers, AroundSomebodyIsWhatIsInTheirRoom) {
  HomeView home;
  home.walks.emplace_back();
  home.things = {thing("microwave", "kitchen", {2, 0, 1}), thing("bed", "bedroom", {3, 0, 0.5})};
  FrameResult result = glance_in("kitchen", 500, rooms::Verdict::kRoom);
  result.place = at_the_origin();
  const service::SpeakingSettings settings;
  const auto prompts =
      answer({1, 500, service::Question::kAroundMe, ""}, {home, &result, settings, 500});
  ASSERT_THAT(prompts, SizeIs(1));
  EXPECT_THAT(prompts[0].text, ::testing::HasSubstr("icrowave at 12 o'clock"));
}

TEST(Answers, OfARoomThatPhotosAloneShowItIsNotSaidThatNothingIsThere) {
  HomeView home;
  home.walks.emplace_back();
  const FrameResult result = glance_in("pantry", 500, rooms::Verdict::kRoom);
  const auto prompts = answer({1, 500, service::Question::kAroundMe, ""}, {home, &result, {}, 500});
  ASSERT_THAT(prompts, SizeIs(1));
  EXPECT_EQ(prompts[0].text, "I have no map of this room yet.");
}

TEST(Answers, TellWhatTheMapKnowsOfThingsAndRooms) {
  HomeView home;
  home.rooms = {{"bedroom", "bedroom"}, {"kitchen", "kitchen"}};
  home.things = {thing("table", "kitchen", {2, 0, 0.3}), thing("cup", "kitchen", {2, 0, 0.8})};
  FrameResult result = glance_in("kitchen", 500, rooms::Verdict::kRoom);
  const service::SpeakingSettings settings;
  const auto told = [&](service::Question question, const std::string& subject,
                        bool is_room = false, const FrameResult* seen = nullptr) {
    return answer({1, 600, question, subject, is_room}, {home, seen, settings, 600}).at(0).text;
  };
  using service::Question;
  EXPECT_EQ(told(Question::kWhatIsOn, "table"), "On the table: cup.");
  EXPECT_EQ(told(Question::kWhatIsOn, "piano"), "I know no piano here.");
  EXPECT_EQ(told(Question::kWhatIsIn, "kitchen"), "In the kitchen: table and cup.");
  EXPECT_EQ(told(Question::kWhatIsIn, "attic"), "I know no attic here.");
  EXPECT_EQ(told(Question::kWhichRooms, ""), "I know 2 rooms.");
  EXPECT_EQ(told(Question::kWhatChanged, ""), "I know of no change.");
  home.latest.gone = {thing("chair", "kitchen", {1, 1, 0.5})};
  EXPECT_EQ(told(Question::kWhatChanged, ""), "No longer in the kitchen: chair.");
  EXPECT_EQ(told(Question::kWhereIs, "kitchen", true, &result), "You are in the kitchen.");
  EXPECT_EQ(told(Question::kWhatCanIAsk, ""), "You can ask: where am I, what is around me.");
  EXPECT_EQ(told(Question::kDescribeRoom, "", false, &result),
            "I do not know how large the kitchen is.");
}

TEST(Answers, ADoorIsWhereRoomsMeet) {
  HomeView home;
  const auto floor = guide::testing::two_rooms().grid();
  home.layout = guide::testing::layout_of_two_rooms(floor);
  FrameResult result = glance_in("bedroom", 500, rooms::Verdict::kRoom);
  result.place = at_the_origin();
  result.place->room = "bedroom";
  result.place->plan_from_camera.translation = {1, 3.45, 1.3};
  const service::SpeakingSettings settings;
  const auto where = [&] {
    return answer({1, 600, service::Question::kWhereIs, "door"}, {home, &result, settings, 600})
        .at(0)
        .text;
  };
  EXPECT_EQ(where(), "The door is at 12 o'clock, 3 metres.");
  EXPECT_THAT(names_in(home).goals, ::testing::ElementsAre("door", "way out"));
  home.things = {thing("door", "bedroom", {1, 1, 1})};
  EXPECT_EQ(where(), "The door is at 3 o'clock, 2 metres.") << "one that was found counts";
}

TEST(Answers, ADoorOfARoomThatHasNoneIsSaidToBeUnknown) {
  HomeView home;
  const auto floor = guide::testing::two_rooms().grid();
  home.layout = guide::testing::layout_of_two_rooms(floor);
  service::SpeakingSettings settings;
  service::Ask door{1, 0, service::Question::kTakeMeTo, "door"};
  const auto told = [&] { return answer(door, {home, nullptr, settings, 0}).at(0).text; };
  door.in_room = "hall";
  EXPECT_EQ(told(), "I know no door of the hall.");
  door.question = service::Question::kWhereIs;
  EXPECT_EQ(told(), "I know no door of the hall.");
  door.to_room = "kitchen";
  EXPECT_EQ(told(), "I know no door between the hall and the kitchen.");
  settings.language = "de";
  EXPECT_EQ(told(), "Ich kenne keine Tür zwischen der Diele und der Küche.");
  settings.language = "es";
  EXPECT_EQ(told(), "No conozco ninguna puerta entre el vestíbulo y la cocina.");
  settings.language = "fr";
  EXPECT_EQ(told(), "Aucune porte connue entre le hall et la cuisine.");
  door.in_room = "bedroom";
  settings.language = "en";
  EXPECT_EQ(told(), "The door is in the bedroom.");
}

TEST(Answers, WhoAsksForAWayOutThatNobodyAddedHearsWhoCanAddIt) {
  HomeView home;
  const service::SpeakingSettings settings;
  using service::Question;
  const auto told = [&](service::Ask ask) {
    return answer(ask, {home, nullptr, settings, 0}).at(0).text;
  };
  const std::string mend = "Nobody told me the way out. Your helper can add it.";
  for (const auto question : {Question::kWhereIs, Question::kWayTo, Question::kTakeMeTo}) {
    service::Ask out{1, 0, question, ""};
    out.is_way_out = true;
    EXPECT_EQ(told(out), mend);
    EXPECT_EQ(told({1, 0, question, "exit"}), mend);
  }
  home.things = {thing("front door", "hall", {1, 1, 1})};
  EXPECT_EQ(told({1, 0, Question::kWhereIs, "exit"}), "The way out is in the hall.");
  EXPECT_EQ(told({1, 0, Question::kWhereIs, "front door"}), "The front door is in the hall.");
}

TEST(Answers, ASpotWithoutAPlaceDoesNotHideTheWayOut) {
  HomeView home;
  home.things = {thing("front door", "hall", {1, 1, 1})};
  ViewedSpot spot;
  spot.stored.name = spot.thing.name = "exit";  // its walk was forgotten
  home.spots = {spot};
  const service::SpeakingSettings settings;
  service::Ask out{1, 0, service::Question::kWhereIs, ""};
  out.is_way_out = true;
  const service::Ask by_name{1, 0, service::Question::kWhereIs, "exit"};
  for (const service::Ask& ask : {out, by_name}) {
    EXPECT_EQ(answer(ask, {home, nullptr, settings, 0}).at(0).text, "The way out is in the hall.");
  }
  home.spots[0].thing = thing("exit", "porch", {4, 1, 1});
  for (const service::Ask& ask : {out, by_name}) {
    EXPECT_THAT(answer(ask, {home, nullptr, settings, 0}).at(0).text, HasSubstr("porch"));
  }
}

TEST(Answers, DirectionsRestOnAPictureAndSayWhatIsAheadNow) {
  HomeView home;
  FrameResult result = glance_in("kitchen", 500, rooms::Verdict::kRoom);
  const service::SpeakingSettings settings;
  using service::Question;
  for (const auto question :
       {Question::kWhichWay, Question::kWhatIsAhead, Question::kDescribeRoom}) {
    EXPECT_EQ(answer({1, 0, question, ""}, {home, nullptr, settings, 0}).at(0).message_id,
              "device.no_picture");
  }
  const service::Ask ahead{1, 600, Question::kWhatIsAhead, ""};
  EXPECT_EQ(answer(ahead, {home, &result, settings, 600}).at(0).message_id, "ahead.unknown");
  result.obstacle.emplace().ahead_left_m = {1, 0};
  EXPECT_EQ(answer(ahead, {home, &result, settings, 600}).at(0).text,
            "Something is ahead now, 1 metre.");
  result.place = at_the_origin();
  home.things = {thing("fridge", "kitchen", {3, 0, 1})};
  EXPECT_EQ(answer({1, 600, Question::kWhichWay, ""}, {home, &result, settings, 600}).at(0).text,
            "You face the fridge, 3 metres.");
}

TEST(Answers, SidesRestOnAPictureAndSeatsDoNot) {
  HomeView home;
  FrameResult result = glance_in("kitchen", 500, rooms::Verdict::kRoom);
  result.place = at_the_origin();
  home.things = {thing("fridge", "kitchen", {0.1, 3, 1}), thing("chair", "kitchen", {-3, 0, 0.5})};
  const service::SpeakingSettings settings;
  using service::Question;
  const auto told = [&](Question question, const FrameResult* seen) {
    return answer({1, 600, question, ""}, {home, seen, settings, 600}).at(0).text;
  };
  EXPECT_THAT(told(Question::kWhatIsLeft, &result), HasSubstr("ridge at 9 o'clock"));
  EXPECT_THAT(told(Question::kWhatIsBehind, &result), HasSubstr("hair at 6 o'clock"));
  EXPECT_EQ(told(Question::kWhatIsRight, &result), "I know of nothing there.");
  EXPECT_EQ(told(Question::kWhatIsLeft, nullptr), "I get no pictures.");
  EXPECT_THAT(told(Question::kWhereToSit, &result), HasSubstr("hair at 6 o'clock"));
  EXPECT_THAT(told(Question::kWhereToSit, nullptr), HasSubstr("in the kitchen"));
}

TEST(Answers, WhatIsAheadIsSureOnlyWhereDepthIsMeasured) {
  LiveMap map;  // with a floor of 6 x 4 m that is free
  map.floor.emplace(Eigen::Vector2d(-1, -2), 0.05,
                    image::Image<fusion::FloorCell>(120, 80, fusion::FloorCell::kFree));
  HomeView home;
  home.map = std::make_shared<const LiveMap>(std::move(map));
  FrameResult result = glance_in("kitchen", 500, rooms::Verdict::kRoom);
  result.place = at_the_origin();
  const service::SpeakingSettings settings;
  const service::Ask ahead{1, 600, service::Question::kWhatIsAhead, ""};
  const auto told = [&] { return answer(ahead, {home, &result, settings, 600}).at(0); };
  EXPECT_EQ(told().message_id, "ahead.free_by_map");
  EXPECT_EQ(told().confidence, guide::Confidence::kProbable);
  result.has_depth = true;
  EXPECT_EQ(told().message_id, "ahead.free");
}

TEST(Answers, WhereAmIRestsOnAPicture) {
  HomeView home;
  const service::SpeakingSettings settings;
  const service::Ask ask{1, 0, service::Question::kWhereAmI, ""};
  EXPECT_EQ(answer(ask, {home, nullptr, settings, 0}).at(0).message_id, "device.nothing_learned");
}

// A home of which the map knows two rooms, and a picture from the bedroom.
class WhereByPlace : public ::testing::Test {
 protected:
  void SetUp() override {
    home.layout = guide::testing::layout_of_two_rooms(guide::testing::two_rooms().grid());
    stand_at(1, 2);
  }
  void stand_at(double x, double y) {
    result.place = at_the_origin();
    result.place->plan_from_camera.translation = {x, y, 1.3};
  }
  void pictures_say(rooms::Verdict verdict, std::vector<rooms::RoomScore> scores) {
    result.decision.emplace();
    result.decision->verdict = verdict;
    result.decision->rooms = std::move(scores);
  }
  std::string told() {
    const service::Ask ask{1, 600, service::Question::kWhereAmI, ""};
    return answer(ask, {home, &result, settings, 600}).at(0).text;
  }

  HomeView home;
  FrameResult result;
  service::SpeakingSettings settings;
};

TEST_F(WhereByPlace, AnswersWhereNothingWasLearned) {
  EXPECT_EQ(told(), "You are in the bedroom.");
  stand_at(3.9, 3.45);
  result.place->sigma_m = 0.3;
  EXPECT_EQ(told(), "Probably the bedroom.") << "in the door, give or take a step";
  result.place.reset();
  EXPECT_EQ(told(), "I have not learned any rooms yet.");
  home.map = std::make_shared<const LiveMap>();
  home.rooms = {{"bedroom", "bedroom"}};
  EXPECT_EQ(told(), "I do not know where you stand. Turn slowly.");
}

TEST_F(WhereByPlace, AnswersInARoomThatWasNotLearned) {
  pictures_say(rooms::Verdict::kNoneOfThem, {{"hall", 0.9}, {"kitchen", 0.1}});
  EXPECT_EQ(told(), "You are in the bedroom.");
  pictures_say(rooms::Verdict::kEither, {{"hall", 0.5}, {"kitchen", 0.5}});
  EXPECT_EQ(told(), "You are in the bedroom.");
  pictures_say(rooms::Verdict::kRoom, {{"hall", 0.99}});
  EXPECT_EQ(told(), "You are in the hall.") << "by pictures, which weigh the place, too";
}

TEST_F(WhereByPlace, IsOneOfTwoOpinionsOnARoomThatWasLearned) {
  pictures_say(rooms::Verdict::kNotSure, {{"kitchen", 0.5}, {"bedroom", 0.3}, {"hall", 0.2}});
  EXPECT_EQ(told(), "Probably the bedroom.");
  pictures_say(rooms::Verdict::kNoneOfThem, {{"bedroom", 0.99}, {"kitchen", 0.01}});
  EXPECT_EQ(told(), "You are in the bedroom.");
  pictures_say(rooms::Verdict::kEither, {{"kitchen", 0.5}, {"bedroom", 0.5}});
  EXPECT_EQ(told(), "Either the kitchen or the bedroom.");
  pictures_say(rooms::Verdict::kNotSure, {{"kitchen", 0.9}, {"bedroom", 0.01}});
  stand_at(3.9, 3.45);
  result.place->sigma_m = 1;
  EXPECT_EQ(told(), "I am not sure. Turn slowly.");
}

TEST_F(WhereByPlace, CallsARoomOutThatWasNotLearned) {
  Announcer announcer;
  const auto called = [&] { return announcer.after({home, &result, settings, 600}); };
  EXPECT_THAT(called(), SizeIs(0));
  const auto told = called();
  ASSERT_THAT(told, SizeIs(1));
  EXPECT_EQ(told[0].text, "Now in the bedroom.");
  EXPECT_THAT(called(), SizeIs(0));
}

TEST_F(WhereByPlace, IsByTheNamesOfTheWalksWhereTheMapShowsNoFloor) {
  home.layout.reset();
  home.map = std::make_shared<const LiveMap>();
  const auto walked = [&](double x, const std::string& room, bool on_map = true) {
    ViewedKeyframe one{{}, room, on_map};
    one.keyframe.pose.world_from_keyframe.translation = {x, 2, 1.3};
    home.keyframes.push_back(one);
  };
  walked(0.6, "study");
  walked(1.3, "study");
  walked(1.2, "elsewhere", false);
  walked(4, "hall");
  EXPECT_EQ(told(), "Probably the study.");
  walked(1.8, "hall");
  EXPECT_EQ(told(), "I have not learned any rooms yet.") << "between two of them";
  home.keyframes.back().room = "";
  EXPECT_EQ(told(), "I have not learned any rooms yet.") << "where somebody walked unnamed";
}

}  // namespace
}  // namespace roomwise::live
