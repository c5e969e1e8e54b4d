#include "roomwise/guide/answers/room_prompts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/guide/testing/test_times.h"

namespace roomwise::guide {
namespace {

class RoomPromptsTest : public ::testing::Test {
 protected:
  [[nodiscard]] static rooms::RoomDecision decision(rooms::Verdict verdict, double probability) {
    rooms::RoomDecision made;
    made.verdict = verdict;
    made.rooms = {{"kitchen", probability}, {"hall", 1 - probability}};
    made.why = "because";
    return made;
  }

  const MessageCatalogue catalogue_ = MessageCatalogue::built_in();
  const Wording english_{&catalogue_, {}};
};

TEST_F(RoomPromptsTest, ARoomIsSaidAsSurelyAsItIsKnown) {
  const Prompt sure =
      room_prompt(decision(rooms::Verdict::kRoom, 0.97), TurnHint::kLeft, english_, kNow);
  EXPECT_EQ(sure.text, "You are in the kitchen.");
  EXPECT_EQ(sure.message_id, "room.is");
  EXPECT_EQ(sure.replace_key, "room");
  EXPECT_EQ(sure.language, "en");
  EXPECT_EQ(sure.priority, Priority::kAnswer);
  EXPECT_EQ(sure.confidence, Confidence::kSure);
  EXPECT_EQ(sure.sound, Sound::kAnswer);
  EXPECT_EQ(sure.because, "because");
  EXPECT_EQ(sure.valid_until_ns, kNow + 3'000'000'000);
  const Prompt probable =
      room_prompt(decision(rooms::Verdict::kRoom, 0.8), TurnHint::kLeft, english_, kNow);
  EXPECT_EQ(probable.text, "Probably the kitchen.");
  EXPECT_EQ(probable.confidence, Confidence::kProbable);
}

TEST_F(RoomPromptsTest, OneOfTwoRoomsIsSaidWithBoth) {
  const rooms::RoomDecision either = decision(rooms::Verdict::kEither, 0.6);
  const Prompt prompt = room_prompt(either, TurnHint::kLeft, english_, kNow);
  EXPECT_EQ(prompt.text, "Either the kitchen or the hall.");
  EXPECT_EQ(prompt.confidence, Confidence::kProbable);
  SpeakingStyle german;
  german.language = "de";
  rooms::RoomDecision rooms = either;
  rooms.rooms = {{"Küche", 0.6}, {"Flur", 0.4}};
  EXPECT_EQ(room_prompt(rooms, TurnHint::kLeft, {&catalogue_, german}, kNow).text,
            "Entweder die Küche oder der Flur.");
  EXPECT_EQ(entered_prompt(either, english_, kNow), std::nullopt) << "nobody asked";
}

TEST_F(RoomPromptsTest, WhoIsNotSureSaysSoAndWhereToTurn) {
  const auto text = [&](TurnHint hint) {
    const Prompt prompt =
        room_prompt(decision(rooms::Verdict::kNotSure, 0.5), hint, english_, kNow);
    EXPECT_EQ(prompt.confidence, Confidence::kUnsure);
    EXPECT_EQ(prompt.sound, Sound::kUnsure);
    return prompt.text;
  };
  EXPECT_EQ(text(TurnHint::kLeft), "I am not sure. Turn slowly to the left.");
  EXPECT_EQ(text(TurnHint::kRight), "I am not sure. Turn slowly to the right.");
  EXPECT_EQ(text(TurnHint::kAnywhere), "I am not sure. Turn slowly.");
}

TEST_F(RoomPromptsTest, AnUnknownPlaceIsNoRoom) {
  const Prompt prompt =
      room_prompt(decision(rooms::Verdict::kNoneOfThem, 1), TurnHint::kLeft, english_, kNow);
  EXPECT_EQ(prompt.text, "I do not know this place.");
  EXPECT_EQ(prompt.sound, Sound::kLost);
  EXPECT_EQ(prompt.confidence, Confidence::kUnsure);
}

TEST_F(RoomPromptsTest, OnlySureRoomsAreCalledOut) {
  const auto entered = entered_prompt(decision(rooms::Verdict::kRoom, 0.95), english_, kNow);
  ASSERT_TRUE(entered);
  EXPECT_EQ(entered->text, "Now in the kitchen.");
  EXPECT_EQ(entered->priority, Priority::kCallout);
  EXPECT_EQ(entered->replace_key, "room");
  EXPECT_FALSE(entered_prompt(decision(rooms::Verdict::kRoom, 0.8), english_, kNow));
  EXPECT_FALSE(entered_prompt(decision(rooms::Verdict::kNotSure, 0.95), english_, kNow));
  EXPECT_FALSE(entered_prompt(decision(rooms::Verdict::kNoneOfThem, 1), english_, kNow));
}

TEST_F(RoomPromptsTest, ANamedRoomIsConfirmed) {
  const Wording german{&catalogue_, {.language = "de"}};
  EXPECT_EQ(named_prompt("kitchen", german, kNow).text, "Danke. Hier ist die Küche.");
}

}  // namespace
}  // namespace roomwise::guide
