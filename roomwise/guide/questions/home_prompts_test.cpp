#include "roomwise/guide/questions/home_prompts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/guide/questions/refusal_prompts.h"
#include "roomwise/guide/testing/drawn_floor.h"

namespace roomwise::guide {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::ElementsAre;

constexpr DepthAhead kFreeByDepth{.is_measured = true, .obstacle_m = {}};

KnownThing standing(const std::string& name, const Vector3d& middle_m, const Vector3d& size_m,
                    const std::string& room = "bedroom", double probability = 0.95) {
  KnownThing thing;
  thing.name = name;
  thing.probability = probability;
  thing.box_keyframe.size_m = size_m;
  thing.position_plan = middle_m;
  thing.room = room;
  return thing;
}

std::vector<std::string> said(const std::vector<Prompt>& prompts) {
  std::vector<std::string> result;
  for (const Prompt& prompt : prompts) result.push_back(prompt.text);
  return result;
}

class HomePromptsTest : public ::testing::Test {
 protected:
  HomePromptsTest()
      : grid_(testing::two_rooms().grid()), layout_(testing::layout_of_two_rooms(grid_)) {}

  [[nodiscard]] HomeMap map() const { return {&grid_, &layout_, layout_.doorways(), things_}; }
  [[nodiscard]] Vector2d middle_of_kitchen() const {
    return std::ranges::find(layout_.rooms(), "kitchen", &rooms::RoomExtent::name)->middle_plan;
  }
  [[nodiscard]] std::vector<std::string> on(const std::string& surface) const {
    return said(on_prompts(surface, map(), nowhere_, english_, today_));
  }

  const MessageCatalogue catalogue_ = MessageCatalogue::built_in();
  const Wording english_{&catalogue_, {"en", DistanceUnit::kSteps, 1.0}};
  const fusion::FloorGrid grid_;
  const rooms::RoomLayout layout_;
  const UserLocation nowhere_;
  const Today today_{0, CalendarTime{2026, 11, 26, 12}};
  std::vector<KnownThing> things_;
};

TEST_F(HomePromptsTest, OnATableIsWhatStandsOverItAndNotOnTheFloor) {
  things_ = {standing("table", {2, 2, 0.37}, {1.6, 0.8, 0.74}),
             standing("cup", {2.5, 2.2, 0.79}, {0.1, 0.1, 0.1}),
             standing("chair", {2.2, 2.3, 0.5}, {0.5, 0.5, 0.9}),
             standing("clock", {2, 2, 2}, {0.3, 0.1, 0.3}),
             standing("bottle", {2, 2.6, 0.9}, {0.1, 0.1, 0.3}),
             standing("vase", {1.5, 2, 0.9}, {0.1, 0.1, 0.3}, "bedroom", 0.6)};
  EXPECT_THAT(on("table"), ElementsAre("On the table: cup.", "Probably on the table: vase."));
  EXPECT_THAT(on("cup"), ElementsAre("I know of nothing on the cup."));
  things_[0].yaw_rad = 1.5707963;
  EXPECT_THAT(on("table"), ElementsAre("On the table: bottle.")) << "the table is turned";
  things_[0].position_plan.reset();
  EXPECT_THAT(on("table"), ElementsAre("I do not know yet where the table stands."));
}

TEST_F(HomePromptsTest, WhatIsInAThingIsNotOnIt) {
  things_ = {standing("refrigerator", {2, 2, 0.9}, {0.6, 0.6, 1.8}),
             standing("milk", {2, 2, 1.3}, {0.1, 0.1, 0.2}),
             standing("vase", {2, 2, 1.92}, {0.1, 0.1, 0.2})};
  EXPECT_THAT(on("refrigerator"), ElementsAre(::testing::HasSubstr(": vase.")));
}

TEST_F(HomePromptsTest, OfThingsItIsToldSinceWhenOneWasNotSeen) {
  things_ = {standing("table", {2, 2, 0.37}, {1.6, 0.8, 0.74}),
             standing("cup", {2.5, 2.2, 0.79}, {0.1, 0.1, 0.1}),
             standing("book", {2.4, 2.2, 0.79}, {0.1, 0.1, 0.1})};
  things_[1].seen = CalendarTime{2026, 11, 25, 9};
  things_[2].seen = CalendarTime{2026, 11, 20, 9};
  EXPECT_THAT(on("table"), ElementsAre("Probably on the table: cup and book.", "Seen on Friday."));
}

TEST_F(HomePromptsTest, WhatWasSeenLongAgoIsProbable) {
  things_ = {standing("table", {2, 2, 0.37}, {1.6, 0.8, 0.74}),
             standing("remote control", {2.5, 2.2, 0.79}, {0.1, 0.1, 0.1})};
  things_[1].seen = CalendarTime{2026, 10, 17, 9};
  EXPECT_EQ(on("table").at(0), "Probably on the table: remote control.");
  EXPECT_EQ(said(in_prompts("bedroom", map(), english_, today_)).at(1),
            "Probably in the bedroom: remote control.");
  things_[1].position_plan = Vector3d(3, 1, 1);
  const UserLocation here{Pose{Vector2d(1, 1), 0, 0.05}, "bedroom"};
  EXPECT_TRUE(said(facing_prompts(map(), here, english_, today_))
                  .at(0)
                  .starts_with("You probably face the remote control, "));
  EXPECT_FALSE(Goal::of(things_[1], today_.date).is_sure);
  EXPECT_TRUE(Goal::of(things_[1], things_[1].seen).is_sure);
}

TEST_F(HomePromptsTest, OfSeveralTablesOneWhosePlaceIsKnownIsAnsweredOf) {
  things_ = {standing("table", {5, 2, 0.37}, {1, 1, 0.74}),
             standing("table", {2, 2, 0.37}, {1.6, 0.8, 0.74}, "bedroom", 0.9),
             standing("cup", {2.5, 2.2, 0.79}, {0.1, 0.1, 0.1})};
  things_[0].position_plan.reset();
  EXPECT_THAT(on("table"), ElementsAre("On the table: cup."));
  const UserLocation here{Pose{Vector2d(1, 1), 0, 0.05}, "bedroom"};
  EXPECT_THAT(said(on_prompts("table", map(), here, english_, today_)),
              ElementsAre("On the table: cup."));
}

TEST_F(HomePromptsTest, InARoomAreItsThingsFourAtATime) {
  EXPECT_THAT(said(in_prompts("kitchen", map(), english_, today_)),
              ElementsAre("I know of nothing in the kitchen."));
  for (const char* name : {"table", "chair", "chair", "stove", "fridge", "sink"}) {
    things_.push_back(standing(name, {2, 2, 0.4}, {0.5, 0.5, 0.5}, "kitchen"));
  }
  things_.push_back(standing("bed", {2, 2, 0.4}, {2, 1, 0.5}));
  EXPECT_THAT(said(in_prompts("kitchen", map(), english_, today_)),
              ElementsAre("In the kitchen: table, chair, stove and fridge.", "Then: sink."));
}

TEST_F(HomePromptsTest, RoomsAreCountedAndNamed) {
  EXPECT_THAT(said(rooms_prompts({"kitchen", "bedroom"}, english_, today_)),
              ElementsAre("I know 2 rooms.", "Kitchen and bedroom."));
  EXPECT_THAT(said(rooms_prompts({"kitchen"}, english_, today_)),
              ElementsAre("I know 1 room.", "Kitchen."));
}

TEST_F(HomePromptsTest, AheadIsWhatDepthShowsNowAndWhatTheMapHas) {
  const Vector2d place(1, 1);
  const UserLocation here{Pose{place, 0, 0.05}, "bedroom"};
  EXPECT_THAT(said(ahead_prompts(map(), nowhere_, kFreeByDepth, english_, today_)),
              ElementsAre("I do not know what is ahead."));
  const auto wall = said(ahead_prompts(map(), here, DepthAhead{true, 0.9}, english_, today_));
  ASSERT_EQ(wall.size(), 2U);
  EXPECT_EQ(wall[0], "Something is ahead now, 1 step.");
  EXPECT_TRUE(wall[1].starts_with("Something stands ahead, ")) << wall[1];
  // What stands where the floor ends is named.
  double wall_m = 0;
  while (grid_.at(Vector2d(place.x() + wall_m, place.y())) == fusion::FloorCell::kFree) {
    wall_m += 0.01;
  }
  things_ = {standing("wardrobe", {place.x() + wall_m + 0.2, 1, 1}, {0.5, 0.5, 2})};
  const auto wardrobe = said(ahead_prompts(map(), here, kFreeByDepth, english_, today_));
  ASSERT_EQ(wardrobe.size(), 1U);
  EXPECT_TRUE(wardrobe[0].starts_with("The wardrobe is ahead, ")) << wardrobe[0];
}

TEST_F(HomePromptsTest, WithoutDepthWhatIsAheadIsTheMapsAndNeverSure) {
  const UserLocation here{Pose{Vector2d(3, 1), 0, 0.05}, "bedroom"};
  const auto told = [&] {
    const auto prompts = ahead_prompts(map(), here, {}, english_, today_);
    EXPECT_EQ(prompts.size(), 1U);
    EXPECT_NE(prompts.at(0).confidence, Confidence::kSure);
    return prompts.at(0).text;
  };
  EXPECT_TRUE(told().starts_with("By the map, something stands ahead, ")) << told();
  things_ = {standing("wardrobe", {4.2, 1, 1}, {0.5, 0.5, 2})};
  EXPECT_TRUE(told().starts_with("By the map, the wardrobe is ahead, ")) << told();
}

TEST_F(HomePromptsTest, TheFreeStretchAheadEndsWhereTheMapKnowsNoMoreAndBeginsAtTheFeet) {
  using fusion::FloorCell;
  const UserLocation here{Pose{Vector2d(1.05, 2.05), 0, 0.05}, "bedroom"};
  const auto told = [&](const Eigen::Vector2i& cell, FloorCell state) {
    const auto floor = testing::two_rooms().fill(cell, cell + Eigen::Vector2i(1, 1), state).grid();
    const HomeMap map{&floor, &layout_, layout_.doorways(), {}};
    return said(ahead_prompts(map, here, kFreeByDepth, english_, today_)).at(0);
  };
  EXPECT_EQ(told({30, 22}, FloorCell::kUnknown), "I know of nothing ahead for 2 steps.")
      << "a place beside the line";
  EXPECT_EQ(told({12, 20}, FloorCell::kOccupied).substr(0, 23), "Something stands ahead,")
      << "right before the feet";
  EXPECT_EQ(told({12, 20}, FloorCell::kOccupied), told({11, 20}, FloorCell::kOccupied));
  EXPECT_EQ(told({10, 22}, FloorCell::kOccupied), "Something stands ahead, 3 steps.")
      << "what one stands beside is not ahead";
  EXPECT_EQ(told({10, 22}, FloorCell::kUnknown), "I do not know what is ahead.");
}

TEST_F(HomePromptsTest, WhoIsToldThatSomethingIsAheadIsNotToldThatTheMapHasNothingThere) {
  const UserLocation here{Pose{Vector2d(1.05, 2.05), 0, 0.05}, "bedroom"};
  const auto floor =
      testing::two_rooms().fill({30, 22}, {31, 23}, fusion::FloorCell::kUnknown).grid();
  const HomeMap map{&floor, &layout_, layout_.doorways(), {}};
  EXPECT_THAT(said(ahead_prompts(map, here, DepthAhead{true, 0.9}, english_, today_)),
              ElementsAre("Something is ahead now, 1 step."));
}

TEST_F(HomePromptsTest, FacingIsTheNearestAtTwelve) {
  const UserLocation here{Pose{Vector2d(1, 1), 0, 0.05}, "bedroom"};
  things_ = {standing("bed", {1, 3, 0.4}, {1, 1, 0.5}), standing("lamp", {3, 1, 1}, {0, 0, 0}),
             standing("tv", {4, 1, 1}, {0, 0, 0})};
  EXPECT_THAT(said(facing_prompts(map(), here, english_, today_)),
              ElementsAre("You face the lamp, 2 steps."));
  things_[1].probability = 0.6;
  EXPECT_THAT(said(facing_prompts(map(), here, english_, today_)),
              ElementsAre("You probably face the lamp, 2 steps."));
  things_.resize(1);
  const auto nothing = facing_prompts(map(), here, english_, today_);
  ASSERT_EQ(nothing.size(), 1U);
  EXPECT_EQ(nothing[0].confidence, Confidence::kUnsure);
  EXPECT_EQ(facing_prompts(map(), nowhere_, english_, today_)[0].message_id, "route.no_place");
}

TEST_F(HomePromptsTest, ARoomIsItsFloorWhereItLeadsAndItsThingsClockwiseFromTheDoor) {
  const auto bedroom = *std::ranges::find(layout_.rooms(), "bedroom", &rooms::RoomExtent::name);
  const Vector2d middle = bedroom.middle_plan;
  const Vector2d to_door = (layout_.doorways()[0].middle_plan - middle).normalized();
  const auto beside = [&](double clockwise_rad) {
    const Vector2d at = middle + Eigen::Rotation2Dd(-clockwise_rad) * to_door;
    return Vector3d(at.x(), at.y(), 0.5);
  };
  things_ = {standing("bed", beside(3), {0.5, 0.5, 0.5}),
             standing("lamp", beside(5), {0.5, 0.5, 0.5}),
             standing("wardrobe", beside(1), {0.5, 0.5, 0.5}),
             standing("stove", {9, 9, 0.5}, {0.5, 0.5, 0.5}, "kitchen")};
  const auto told = said(describe_prompts("bedroom", map(), nowhere_, english_, today_));
  ASSERT_EQ(told.size(), 3U);
  EXPECT_TRUE(told[0].starts_with("The bedroom has about ")) << told[0];
  EXPECT_EQ(told[1], "It leads to the kitchen.");
  EXPECT_EQ(told[2], "Clockwise from the door: wardrobe, bed and lamp.");
  things_[0].probability = 0.6;
  const auto unsure = said(describe_prompts("bedroom", map(), nowhere_, english_, today_));
  ASSERT_EQ(unsure.size(), 4U);
  EXPECT_EQ(unsure[3], "Probably, clockwise from the door: bed.");
  EXPECT_THAT(
      said(describe_prompts("attic", {}, nowhere_, english_, today_)),
      ElementsAre("I do not know how large the attic is.", "I know of nothing in the attic."));
}

TEST_F(HomePromptsTest, ADoorThatIsNarrowOrWideIsToldByItsWidth) {
  std::vector<rooms::Doorway> doorways = layout_.doorways();
  const HomeMap map{&grid_, &layout_, doorways, things_};
  const auto told = [&](double width_m, const char* code) {
    doorways[0].width_m = width_m;
    const Wording wording(&catalogue_, {code, DistanceUnit::kSteps, 1.0});
    return said(describe_prompts("bedroom", map, nowhere_, wording, today_)).at(2);
  };
  EXPECT_EQ(told(0.66, "en"), "The door to the kitchen is narrow, 65 centimetres.");
  EXPECT_EQ(told(0.66, "de"), "Die Tür zur Küche ist schmal, 65 Zentimeter.");
  EXPECT_EQ(told(1.14, "en"), "The door to the kitchen is wide, 115 centimetres.");
  EXPECT_EQ(told(0.86, "en"), "I know of nothing in the bedroom.") << "as doors are";
  EXPECT_EQ(told(0, "en"), "I know of nothing in the bedroom.") << "not known";
}

TEST_F(HomePromptsTest, WhereRoomsAreOpenToEachOtherNoDoorIsTold) {
  things_ = {standing("bed", {2, 3, 0.3}, {2, 1.6, 0.6})};
  std::vector<rooms::Doorway> open = layout_.doorways();
  for (rooms::Doorway& doorway : open) doorway.is_framed = false;
  const HomeMap map{&grid_, &layout_, open, things_};
  for (const auto& [code, words] :
       std::map<std::string, std::string>{{"en", "Clockwise from the kitchen: bed."},
                                          {"de", "Vom Weg zur Küche im Uhrzeigersinn: Bett."}}) {
    const Wording wording(&catalogue_, {code, DistanceUnit::kSteps, 1.0});
    const auto told = said(describe_prompts("bedroom", map, nowhere_, wording, today_));
    ASSERT_EQ(told.size(), 3U);
    EXPECT_EQ(told[2], words);
  }
}

TEST_F(HomePromptsTest, WhereARoomIsIsToldByRoomsAndDirection) {
  const auto told = [&](const UserLocation& location) {
    return said(room_way_prompts("kitchen", map(), location, english_, today_));
  };
  EXPECT_THAT(told({{}, "kitchen"}), ElementsAre("You are in the kitchen."));
  EXPECT_THAT(told({{}, "bedroom"}), ElementsAre("The kitchen is the next room."));
  EXPECT_THAT(
      told({Pose{Vector2d(1, 1), 0, 0.05}, "bedroom"}),
      ElementsAre("The kitchen is the next room.", ::testing::StartsWith("The kitchen is at ")));
  const Vector2d before_it = middle_of_kitchen() - Vector2d(1, 0);
  EXPECT_THAT(told({Pose{before_it, 0, 0.4}, "bedroom"}),
              ElementsAre("The kitchen is the next room.",
                          "The kitchen is probably at 12 o'clock, 1 step."));
  EXPECT_THAT(told(nowhere_), ElementsAre("I do not know where you stand. Turn slowly."));
}

TEST_F(HomePromptsTest, ChangesAreToldByWhatHappenedAndByRoom) {
  EXPECT_THAT(said(change_prompts({}, english_, today_)), ElementsAre("I know of no change."));
  ChangedThings changed;
  changed.arrived = {standing("chair", {1, 1, 0}, {1, 1, 1}, "kitchen")};
  changed.arrived[0].seen = CalendarTime{2026, 11, 25, 9};
  changed.moved = {standing("table", {1, 1, 0}, {1, 1, 1}, "hall")};
  changed.shifted = {standing("bed", {1, 1, 0}, {1, 1, 1})};
  changed.gone = {standing("chair", {1, 1, 0}, {1, 1, 1}), standing("lamp", {1, 1, 0}, {1, 1, 1})};
  EXPECT_THAT(said(change_prompts(changed, english_, today_)),
              ElementsAre("New in the kitchen: chair.", "Moved: table, now in the hall.",
                          "Pushed or turned in the bedroom: bed.",
                          "No longer in the bedroom: chair and lamp.", "Seen yesterday."));
}

TEST_F(HomePromptsTest, AChangeInARoomThatIsNotKnownIsToldToo) {
  KnownThing lamp = standing("lamp", {1, 1, 0}, {1, 1, 1});
  lamp.room.reset();
  EXPECT_THAT(said(change_prompts({{lamp}, {lamp}, {lamp}, {lamp}}, english_, today_)),
              ElementsAre("New, room unknown: lamp.", "Moved, room unknown: lamp.",
                          "Pushed or turned, room unknown: lamp.", "Gone, room unknown: lamp."));
}

TEST_F(HomePromptsTest, EveryRefusalSaysWhatCanBeAsked) {
  const HomeNames home{.things = {"apple", "bed"}, .rooms = {"kitchen"}, .goals = {}};
  const auto refusal = [&](const std::string& text) {
    const auto heard = understand(text, english_.phrases(), home);
    return said(refusal_prompts(heard, home, english_, 0));
  };
  const std::string examples = "You can ask: where am I, what is around me.";
  const std::string of_things = "Or: where is the bed, how far is the bed.";
  const std::string of_rooms = "Or: take me to the kitchen, which rooms are there.";
  EXPECT_THAT(refusal("sing!"),
              ElementsAre("I did not understand.", examples, of_things, of_rooms));
  EXPECT_THAT(refusal("is the window open"),
              ElementsAre("I cannot tell that.", examples, of_things, of_rooms));
  EXPECT_THAT(refusal("where are my socks"),
              ElementsAre("I know no socks here.", examples, of_things, of_rooms));
  EXPECT_THAT(refusal("take me to the kitchn"),
              ElementsAre("Did you mean the kitchen? Then answer yes."));
  const auto asked_for = example_prompts({}, english_, 0);
  EXPECT_THAT(said(asked_for), ElementsAre(examples));
  EXPECT_EQ(asked_for[0].confidence, Confidence::kSure);
}

}  // namespace
}  // namespace roomwise::guide
