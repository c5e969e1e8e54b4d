#include "roomwise/guide/answers/thing_prompts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "roomwise/guide/testing/test_times.h"

namespace roomwise::guide {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::ElementsAre;
using ::testing::Optional;

KnownThing at(const std::string& name, double x, double y, const std::string& room,
              double probability = 0.95) {
  KnownThing thing;
  thing.name = name;
  thing.probability = probability;
  thing.box_keyframe.size_m = Vector3d(0.6, 0.6, 0.6);
  thing.position_plan = Vector3d(x, y, 0.5);
  thing.room = room;
  return thing;
}

std::vector<std::string> texts(const std::vector<Prompt>& prompts) {
  std::vector<std::string> result;
  for (const Prompt& prompt : prompts) result.push_back(prompt.text);
  return result;
}

class ThingPromptsTest : public ::testing::Test {
 protected:
  [[nodiscard]] std::vector<std::string> around(const UserLocation& location) const {
    return texts(around_prompts(location, things_, english_, kNow));
  }
  [[nodiscard]] std::vector<Prompt> where(const std::string& asked,
                                          const UserLocation& location) const {
    return where_prompts(asked, location, things_, doorways_, vocabulary_, english_, kNow);
  }
  static rooms::Doorway door(const std::string& a, const std::string& b) {
    rooms::Doorway doorway;
    doorway.rooms = {a, b};
    return doorway;
  }

  void note(std::size_t thing, const std::string& words) { things_.at(thing).note = words; }

  const MessageCatalogue catalogue_ = MessageCatalogue::built_in();
  // One step is a metre.
  const Wording english_{&catalogue_, {"en", DistanceUnit::kSteps, 1.0}};
  const objects::ObjectVocabulary vocabulary_ = objects::ObjectVocabulary::standard();
  // In the middle of the kitchen, looking along y.
  const UserLocation standing_{Pose{Vector2d(5, 5), std::numbers::pi / 2, 0.05}, "kitchen"};
  std::vector<KnownThing> things_{at("microwave", 5, 8.2, "kitchen"),
                                  at("fridge", 7.3, 5, "kitchen"), at("bed", 5, 10, "bedroom"),
                                  at("lamp", 0, 5, "bedroom", 0.6)};
  const std::vector<rooms::Doorway> doorways_{
      door("corridor", "kitchen"), door("bedroom", "corridor"), door("kitchen", "pantry")};
};

TEST_F(ThingPromptsTest, AroundIsTheNearestFirstAndNoOtherRoom) {
  EXPECT_THAT(around(standing_),
              ElementsAre("Fridge at 3 o'clock, 2 steps.", "Microwave at 12 o'clock, 3 steps."));
}

TEST_F(ThingPromptsTest, WhatIsCloseIsNamedWithoutADirection) {
  things_.push_back(at("chair", 4.2, 5, "kitchen"));
  things_.push_back(at("table", 5, 4.0, "kitchen"));
  EXPECT_THAT(around(standing_),
              ElementsAre("Close to you: chair and table.", "Fridge at 3 o'clock, 2 steps.",
                          "Microwave at 12 o'clock, 3 steps."));
}

TEST_F(ThingPromptsTest, AtMostFourThingsOneOfANameAndLargeOnesBeforeSmallOnes) {
  for (int i = 0; i < 6; ++i) things_.push_back(at("chair", 5 + 0.1 * i, 3, "kitchen"));
  KnownThing vase = at("vase", 6.6, 5, "kitchen");
  vase.box_keyframe.size_m = Vector3d(0.1, 0.1, 0.2);
  things_.push_back(vase);
  things_.push_back(at("table", 5, 7.6, "kitchen"));
  EXPECT_THAT(around(standing_),
              ElementsAre("Chair at 6 o'clock, 2 steps.", "Fridge at 3 o'clock, 2 steps.",
                          "Table at 12 o'clock, 2 steps.", "Microwave at 12 o'clock, 3 steps."));
}

TEST_F(ThingPromptsTest, ASideIsThreeHoursOfTheClock) {
  const auto on = [&](Side side, const UserLocation& location) {
    return texts(side_prompts(side, location, things_, english_, kNow));
  };
  EXPECT_THAT(on(Side::kRight, standing_), ElementsAre("Fridge at 3 o'clock, 2 steps."));
  EXPECT_THAT(on(Side::kLeft, standing_), ElementsAre("I know of nothing there."))
      << "the lamp is in another room";
  things_.push_back(at("chair", 5, 2, "kitchen"));
  EXPECT_THAT(on(Side::kBehind, standing_), ElementsAre("Chair at 6 o'clock, 3 steps."));
  // Who stands at its end has it beside them, though its middle is ahead.
  things_.push_back(at("table", 3.5, 6.8, "kitchen"));
  things_.back().box_keyframe.size_m = Vector3d(1, 4, 0.7);
  EXPECT_THAT(on(Side::kLeft, standing_), ElementsAre("Table at 11 o'clock, 2 steps."));
  EXPECT_THAT(on(Side::kLeft, {std::nullopt, "kitchen"}),
              ElementsAre("I do not know where you stand. Turn slowly."));
}

TEST_F(ThingPromptsTest, WhereToSitIsTheNearestSeatHereOrElsewhere) {
  const auto seats = [&] {
    return texts(seat_prompts(standing_, things_, doorways_, vocabulary_, english_, kNow));
  };
  EXPECT_THAT(seats(), ElementsAre("The bed is in the bedroom, through the corridor."));
  things_.push_back(at("stool", 5, 2, "kitchen"));
  EXPECT_THAT(seats(), ElementsAre("Stool at 6 o'clock, 3 steps."));
  things_ = {at("fridge", 7.3, 5, "kitchen")};
  EXPECT_THAT(seats(), ElementsAre("I know of nothing to sit on."));
}

TEST_F(ThingPromptsTest, UnsureThingsAreProbable) {
  things_ = {at("fridge", 7.3, 5, "kitchen", 0.6), at("chair", 4.2, 5, "kitchen", 0.6),
             at("table", 5, 4.0, "kitchen")};
  KnownThing moved = at("bin", 5, 8.3, "kitchen", 0.79);
  things_.push_back(moved);
  EXPECT_THAT(around(standing_),
              ElementsAre("Close to you: table.", "Probably close to you: chair.",
                          "Probably fridge at 3 o'clock, 2 steps.",
                          "Probably bin at 12 o'clock, 3 steps."));
}

TEST_F(ThingPromptsTest, WithoutARoomOnlyWhatIsNearCounts) {
  EXPECT_THAT(around({standing_.pose, std::nullopt}),
              ElementsAre("Probably fridge at 3 o'clock, 2 steps.",
                          "Probably microwave at 12 o'clock, 3 steps."));
}

TEST_F(ThingPromptsTest, WithoutAPoseTheRoomIsTold) {
  things_.push_back(at("stove", 6, 6, "kitchen", 0.5));
  EXPECT_THAT(around({std::nullopt, "kitchen"}),
              ElementsAre("In this room: microwave and fridge.", "Probably in this room: stove."));
  EXPECT_THAT(around({Pose{Vector2d(5, 5), 0, 0.9}, "bedroom"}),
              ElementsAre("In this room: bed.", "Probably in this room: lamp."));
  EXPECT_THAT(around({std::nullopt, "pantry"}), ElementsAre("I know of nothing around you."));
  EXPECT_THAT(around({}), ElementsAre("I do not know where you stand. Turn slowly."));
}

TEST_F(ThingPromptsTest, TheAnswersPartsHaveKeysAndTimesOneAfterTheOther) {
  const auto prompts = around_prompts(standing_, things_, english_, kNow);
  ASSERT_EQ(prompts.size(), 2u);
  EXPECT_EQ(prompts[0].replace_key, "around");
  EXPECT_EQ(prompts[0].sound, Sound::kAnswer);
  EXPECT_EQ(prompts[0].valid_until_ns, kNow + 2 * kSecond);
  EXPECT_EQ(prompts[1].replace_key, "around/2");
  EXPECT_EQ(prompts[1].sound, Sound::kNone);
  EXPECT_EQ(prompts[1].valid_until_ns, kNow + 6 * kSecond);
}

TEST_F(ThingPromptsTest, WhereIsInTheSameRoomByDirection) {
  const auto prompts = where("microwave", standing_);
  EXPECT_THAT(texts(prompts), ElementsAre("The microwave is at 12 o'clock, 3 steps."));
  EXPECT_EQ(prompts[0].replace_key, "thing microwave");
  EXPECT_EQ(prompts[0].confidence, Confidence::kSure);
  EXPECT_EQ(prompts[0].valid_until_ns, kNow + 2 * kSecond);
  things_.push_back(at("toaster", 5, 4.2, "kitchen"));
  EXPECT_THAT(texts(where("toaster", standing_)),
              ElementsAre("The toaster is close to you, at 6 o'clock."));
}

TEST_F(ThingPromptsTest, WhereIsInAnotherRoomByTheRoomsOnTheWay) {
  const auto text = [&](const std::string& asked, const UserLocation& location) {
    return texts(where(asked, location)).front();
  };
  EXPECT_EQ(text("bed", standing_), "The bed is in the bedroom, through the corridor.");
  EXPECT_EQ(text("bed", {std::nullopt, "pantry"}),
            "The bed is in the bedroom, through the kitchen and the corridor.");
  EXPECT_EQ(text("bed", {std::nullopt, "corridor"}), "The bed is in the bedroom, the next room.");
  EXPECT_EQ(text("bed", {std::nullopt, "bedroom"}), "The bed is in this room.");
  EXPECT_EQ(text("bed", {std::nullopt, "attic"}), "The bed is in the bedroom.");
  EXPECT_EQ(text("bed", {}), "The bed is in the bedroom.");
  EXPECT_EQ(text("lamp", {}), "The lamp is probably in the bedroom.");
}

TEST_F(ThingPromptsTest, SeveralAreTheNearestAndTheirNumber) {
  things_.push_back(at("bed", 5, 20, "pantry"));
  things_.push_back(at("bed", 5, 6.2, "attic"));
  const auto prompts = where("bed", standing_);
  EXPECT_THAT(texts(prompts), ElementsAre("The bed is in the pantry, the next room.",
                                          "I know 3 beds. This was the nearest."));
  EXPECT_EQ(prompts[1].replace_key, "thing bed/count");
  EXPECT_THAT(texts(where("bed", {})), ElementsAre("The bed is in the bedroom.", "I know 3 beds."));
}

TEST_F(ThingPromptsTest, OfWhatPeopleCarryAboutItIsToldWhenItWasSeen) {
  const CalendarTime today{2026, 11, 28, 14};
  const auto told = [&](const std::string& name, std::optional<CalendarTime> seen,
                        const Wording& wording) {
    KnownThing thing = at(name, 5, 10, "bedroom");
    thing.seen = seen;
    things_ = {thing};
    return texts(where_prompts(name, {}, things_, doorways_, vocabulary_, wording, kNow, today));
  };
  EXPECT_THAT(told("cup", CalendarTime{2026, 11, 25, 9}, english_),
              ElementsAre("The cup is probably in the bedroom.", "Seen on Wednesday."));
  EXPECT_THAT(told("cup", CalendarTime{2026, 11, 20, 9}, english_),
              ElementsAre("The cup is probably in the bedroom.", "Seen on 20 November."));
  EXPECT_THAT(told("cup", CalendarTime{2025, 3, 1, 9}, english_),
              ElementsAre("The cup is probably in the bedroom.", "Seen on 1 March 2025."));
  EXPECT_THAT(told("cup", CalendarTime{2026, 11, 27, 23}, english_),
              ElementsAre("The cup is probably in the bedroom.", "Seen yesterday."));
  EXPECT_THAT(told("cup", CalendarTime{2026, 11, 28, 8}, english_),
              ElementsAre("The cup is probably in the bedroom.", "Seen this morning."));
  EXPECT_THAT(told("cup", CalendarTime{2026, 11, 28, 13}, english_),
              ElementsAre("The cup is in the bedroom.", "Seen this afternoon."));
  const Wording german{&catalogue_, {"de", DistanceUnit::kSteps, 1.0}};
  EXPECT_EQ(told("cup", CalendarTime{2026, 3, 5, 9}, german)[1], "Gesehen am 5. März.");
  // Not of what stays, not without a date, and not by a clock that is wrong.
  EXPECT_THAT(told("bed", CalendarTime{2026, 11, 25, 9}, english_),
              ElementsAre("The bed is in the bedroom."));
  EXPECT_THAT(told("cup", std::nullopt, english_), ElementsAre("The cup is in the bedroom."));
  EXPECT_THAT(told("cup", CalendarTime{2026, 11, 29, 9}, english_),
              ElementsAre("The cup is in the bedroom."));
  EXPECT_THAT(texts(where("cup", {})), ElementsAre("The cup is in the bedroom."))
      << "today is not known";
}

TEST_F(ThingPromptsTest, TheLongerAgoAThingWasSeenTheLessSurelyItIsThere) {
  KnownThing bed = at("bed", 7.3, 5, "kitchen"), cup = at("cup", 5, 8.3, "kitchen");
  bed.seen = cup.seen = CalendarTime{2026, 11, 27, 9};
  things_ = {bed, cup};
  const auto told = [&](const CalendarTime& today) {
    return texts(around_prompts(standing_, things_, english_, kNow, today));
  };
  EXPECT_THAT(told({2026, 11, 27, 10}),
              ElementsAre("Bed at 3 o'clock, 2 steps.", "Cup at 12 o'clock, 3 steps."));
  EXPECT_THAT(told({2026, 11, 28, 9}),
              ElementsAre("Bed at 3 o'clock, 2 steps.", "Probably cup at 12 o'clock, 3 steps."));
  EXPECT_THAT(told({2027, 11, 28, 9}), ElementsAre("Probably bed at 3 o'clock, 2 steps.",
                                                   "Probably cup at 12 o'clock, 3 steps."));
  EXPECT_EQ(cup.probability_at(std::nullopt), cup.probability) << "nobody knows how long ago";
}

TEST_F(ThingPromptsTest, WhenItWasSeenComesBeforeHowManyThereAre) {
  things_ = {at("cup", 5, 10, "bedroom"), at("cup", 5, 11, "bedroom")};
  for (KnownThing& cup : things_) cup.seen = CalendarTime{2026, 11, 27, 9};
  const auto prompts = where_prompts("cup", {}, things_, doorways_, vocabulary_, english_, kNow,
                                     CalendarTime{2026, 11, 28, 9});
  EXPECT_THAT(texts(prompts), ElementsAre("The cup is probably in the bedroom.", "Seen yesterday.",
                                          "I know 2 cups."));
  EXPECT_EQ(prompts[1].replace_key, "thing cup/seen");
  EXPECT_EQ(prompts[1].sound, Sound::kNone);
}

TEST_F(ThingPromptsTest, AHomeWithoutRoomsStillTellsWhatIsNear) {
  for (KnownThing& thing : things_) thing.room = std::nullopt;
  const UserLocation location{standing_.pose, std::nullopt};
  EXPECT_THAT(texts(where("fridge", location)),
              ElementsAre("The fridge is probably at 3 o'clock, 2 steps."));
  const auto far = where("bed", location);
  EXPECT_THAT(texts(far), ElementsAre("I do not know which room the bed is in."));
  EXPECT_EQ(far[0].confidence, Confidence::kUnsure);
}

TEST_F(ThingPromptsTest, WhatTheHomeLacksIsSaidAsSuch) {
  EXPECT_THAT(texts(where("stove", standing_)), ElementsAre("I know no stove here."));
  EXPECT_THAT(texts(where("cooker", standing_)), ElementsAre("I know no stove here."));
  EXPECT_THAT(texts(where("unicorn", standing_)), ElementsAre("I know no unicorn here."));
}

TEST_F(ThingPromptsTest, ThingsAreMeantByOtherNames) {
  const auto meant = [&](const std::string& asked, const std::string& language) {
    return thing_meant(asked, things_, vocabulary_, catalogue_.in(language));
  };
  EXPECT_THAT(meant("Microwave", "en"), Optional(std::string("microwave")));
  EXPECT_THAT(meant("refrigerator", "en"), Optional(std::string("fridge")));
  EXPECT_THAT(meant("Kühlschrank", "de"), Optional(std::string("fridge")));
  EXPECT_EQ(meant("Kühlschrank", "en"), std::nullopt);
  EXPECT_THAT(meant("four-poster", "en"), Optional(std::string("bed")));
  EXPECT_EQ(meant("stove", "en"), std::nullopt);
  things_.push_back(at("Oma's chest", 1, 1, "bedroom"));
  EXPECT_THAT(meant("oma's chest", "en"), Optional(std::string("Oma's chest")));
}

TEST_F(ThingPromptsTest, WhatAHelperNotedIsSaidWithTheThing) {
  note(0, "hot");
  EXPECT_THAT(texts(where("microwave", standing_)),
              ElementsAre("The microwave is at 12 o'clock, 3 steps.", "Note: hot."));
  EXPECT_THAT(around(standing_),
              ElementsAre("Fridge at 3 o'clock, 2 steps.", "Microwave at 12 o'clock, 3 steps.",
                          "Microwave: hot."));
  note(0, "Mind the step!");
  EXPECT_EQ(texts(where("microwave", standing_)).back(), "Note: Mind the step!");
}

TEST_F(ThingPromptsTest, WhatAHelperNotedIsSaidWhereTheRoomAloneIsKnown) {
  note(1, "door sticks");
  EXPECT_THAT(around({std::nullopt, "kitchen"}),
              ElementsAre("In this room: microwave and fridge.", "Fridge: door sticks."));
}

TEST_F(ThingPromptsTest, WhatAHelperAddedIsToldAsSuchAndForCertain) {
  KnownThing kettle = at("cup", 5, 8.2, "kitchen", 1);
  kettle.added_by_edit = 3;
  kettle.is_confirmed = true;
  things_ = {kettle};
  CalendarTime later;
  later.year = 2099;
  EXPECT_TRUE(things_[0].is_sure(later)) << "nobody takes a helper's word back but a helper";
  const auto prompts = where("cup", standing_);
  EXPECT_THAT(texts(prompts),
              ElementsAre("The cup is at 12 o'clock, 3 steps.", "Your helper added it."));
  EXPECT_EQ(prompts[0].confidence, Confidence::kSure);
}

KnownThing taught_mug() {
  KnownThing mug = at("my blue mug", 5, 8.2, "kitchen", 1);
  mug.box_keyframe.size_m = Vector3d::Zero();
  mug.is_taught = true;
  return mug;
}

TEST_F(ThingPromptsTest, OfAThingThatWasTaughtItIsSaidWhereItLiesAndWhenItWasSeen) {
  things_.front().name = "table";
  KnownThing mug = taught_mug();
  mug.position_plan->z() = 0.85;  // the table's top is at 0.8 m
  mug.seen = CalendarTime{2026, 3, 2, 8};
  things_.push_back(mug);
  const auto prompts =
      where_prompts("my blue mug", {.pose = {}, .room = "bedroom"}, things_, doorways_, vocabulary_,
                    english_, kNow, CalendarTime{2026, 3, 2, 17});
  EXPECT_THAT(texts(prompts), ElementsAre("My blue mug is in the kitchen, through the corridor.",
                                          "On the table.", "Seen this morning."));
}

TEST_F(ThingPromptsTest, AThingThatWasTaughtAndNotSeenSinceIsSaidToBeSo) {
  KnownThing mug = taught_mug();
  mug.position_plan.reset();
  mug.room.reset();
  things_.push_back(mug);
  EXPECT_THAT(texts(where("my blue mug", standing_)),
              ElementsAre("I have not seen my blue mug yet."));
}

}  // namespace
}  // namespace roomwise::guide
