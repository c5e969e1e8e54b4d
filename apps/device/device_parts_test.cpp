#include <gmock/gmock.h>
#include <linux/input.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <sstream>

#include "device_credentials.h"
#include "device_keys.h"
#include "device_voice.h"
#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/service/protocol/prompt_message.h"

namespace roomwise::app {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using Kind = KeyRequest::Kind;

constexpr TimestampNs kSecond = 1'000'000'000;

TEST(TypedKeysTest, AreLettersAndNames) {
  TypedKeys keys;
  EXPECT_THAT(keys.take("w\nz a", 0),
              ElementsAre(KeyRequest{Kind::kWhere, ""}, KeyRequest{Kind::kAround, ""}));
  // In pieces, as a person types; letters within a name ask nothing.
  EXPECT_THAT(keys.take("f wash", 0), ElementsAre(KeyRequest{Kind::kWhichThing, ""}));
  EXPECT_THAT(keys.take("ing ma", 0), IsEmpty());
  EXPECT_THAT(keys.take("chine\nr", 0), ElementsAre(KeyRequest{Kind::kFind, "washing machine"},
                                                    KeyRequest{Kind::kRepeat, ""}));
  EXPECT_THAT(keys.take("g bed\nl bed\nb", 0),
              ElementsAre(KeyRequest{Kind::kTake, "bed"}, KeyRequest{Kind::kWay, "bed"},
                          KeyRequest{Kind::kBlocked, ""}));
  EXPECT_THAT(keys.take("n", 0), ElementsAre(KeyRequest{Kind::kWhichRoom, ""}));
  EXPECT_THAT(keys.take("kitchen\n", 0), ElementsAre(KeyRequest{Kind::kNameRoom, "kitchen"}));
  EXPECT_THAT(keys.take("f\nqx", 0),
              ElementsAre(KeyRequest{Kind::kNoName, ""}, KeyRequest{Kind::kQuiet, ""},
                          KeyRequest{Kind::kExit, ""}));
}

TEST(TypedKeysTest, AQuestionIsTypedAfterAQuestionMark) {
  TypedKeys keys;
  EXPECT_THAT(keys.take("?", 0), ElementsAre(KeyRequest{Kind::kWhichQuestion, ""}));
  EXPECT_THAT(
      keys.take("where is my cup?\nr", 0),
      ElementsAre(KeyRequest{Kind::kInWords, "where is my cup?"}, KeyRequest{Kind::kRepeat, ""}));
}

TEST(TypedKeysTest, APlaceIsMarkedWithANameOrWithout) {
  TypedKeys keys;
  EXPECT_THAT(keys.take("m", 0), ElementsAre(KeyRequest{Kind::kWhichSpot, ""}));
  EXPECT_THAT(keys.take("my chair\nks", 0),
              ElementsAre(KeyRequest{Kind::kMark, "my chair"}, KeyRequest{Kind::kBack, ""},
                          KeyRequest{Kind::kSpots, ""}));
  EXPECT_THAT(keys.take("m\n", 0), ElementsAre(KeyRequest{Kind::kMark, ""}));
  EXPECT_THAT(keys.take("m my\x1b", 0), ElementsAre(KeyRequest{Kind::kNoName, ""}));
}

TEST(TypedKeysTest, AThingIsShownAndThenNamed) {
  TypedKeys keys;
  EXPECT_THAT(keys.take("y", 0), ElementsAre(KeyRequest{Kind::kTeach, ""}));
  EXPECT_THAT(keys.take("c", 0), ElementsAre(KeyRequest{Kind::kWhichName, ""}));
  EXPECT_THAT(keys.take("my mug\n", 0), ElementsAre(KeyRequest{Kind::kNameThing, "my mug"}));
  EXPECT_THAT(keys.take("c\n", 0), ElementsAre(KeyRequest{Kind::kNoName, ""}));
}

TEST(TypedKeysTest, NamesAreMendedAndGivenUp) {
  TypedKeys keys;
  // A letter of two bytes is taken back as one.
  EXPECT_THAT(keys.take("f \x7f\x7f"
                        "bä\x7f"
                        "ex\x08"
                        "d\n",
                        0),
              ElementsAre(KeyRequest{Kind::kFind, "bed"}));
  EXPECT_THAT(keys.take("g be", 0), ElementsAre(KeyRequest{Kind::kWhichThing, ""}));
  EXPECT_THAT(keys.take("\x1bw", 0),
              ElementsAre(KeyRequest{Kind::kNoName, ""}, KeyRequest{Kind::kWhere, ""}));
}

TEST(TypedKeysTest, ANameIsWaitedForSoLong) {
  TypedKeys keys;
  EXPECT_THAT(keys.take("fb", 0), ElementsAre(KeyRequest{Kind::kWhichThing, ""}));
  EXPECT_THAT(keys.take("e", 9 * kSecond), IsEmpty());
  EXPECT_THAT(keys.take("", 18 * kSecond), IsEmpty());
  EXPECT_THAT(keys.take("", 20 * kSecond), ElementsAre(KeyRequest{Kind::kNoName, ""}));
  EXPECT_THAT(keys.take("w", 21 * kSecond), ElementsAre(KeyRequest{Kind::kWhere, ""}));
}

std::string event(int code, int value, int type = EV_KEY, double at_s = 0) {
  input_event pressed{};
  pressed.input_event_sec = static_cast<time_t>(at_s);
  pressed.input_event_usec = static_cast<suseconds_t>(std::lround(1e6 * std::fmod(at_s, 1)));
  pressed.type = static_cast<std::uint16_t>(type);
  pressed.code = static_cast<std::uint16_t>(code);
  pressed.value = value;
  std::string bytes(sizeof pressed, '\0');
  std::memcpy(bytes.data(), &pressed, sizeof pressed);
  return bytes;
}

// For so long from then on.
std::string press(int code, double from_s, double for_s) {
  return event(code, 1, EV_KEY, from_s) + event(0, 0, EV_SYN, from_s) +
         event(code, 2, EV_KEY, from_s + for_s / 2) + event(code, 0, EV_KEY, from_s + for_s);
}

std::vector<KeyRequest> heard_of(const std::string& bytes) {
  ButtonEvents events;
  std::vector<KeyRequest> heard;
  for (std::size_t at = 0; at < bytes.size(); at += 7) {
    const std::string piece = bytes.substr(at, 7);
    std::ranges::move(
        events.take({reinterpret_cast<const std::uint8_t*>(piece.data()), piece.size()}, 0),
        std::back_inserter(heard));
  }
  return heard;
}

TEST(ButtonEventsTest, AreHeardWhenTheyGoUp) {
  EXPECT_THAT(heard_of(press(KEY_1, 3.5, 0.6) + press(KEY_3, 5, 0.1) + press(KEY_A, 6, 0.1) +
                       press(KEY_5, 7, 0.1) + event(KEY_2, 1, EV_KEY, 8)),
              ElementsAre(KeyRequest{Kind::kWhere, ""}, KeyRequest{Kind::kFindNext, ""},
                          KeyRequest{Kind::kQuiet, ""}));
  EXPECT_THAT(heard_of(event(KEY_1, 0, EV_KEY, 5)), IsEmpty()) << "went down before";
}

TEST(ButtonEventsTest, HeldTheyLeadPauseAndEnd) {
  EXPECT_THAT(heard_of(press(KEY_1, 0.9, 0.8) + press(KEY_2, 5, 0.8) + press(KEY_3, 6, 2) +
                       press(KEY_4, 9, 0.8) + press(KEY_5, 10, 2.1) + press(KEY_A, 13, 1)),
              ElementsAre(KeyRequest{Kind::kNext, ""}, KeyRequest{Kind::kBlocked, ""},
                          KeyRequest{Kind::kTakeFound, ""}, KeyRequest{Kind::kPauseOrGoOn, ""},
                          KeyRequest{Kind::kEnd, ""}));
}

// So that they feel it, and nobody ends what leads them by a long "quiet".
TEST(ButtonEventsTest, HeldTheyAreHeardAtOnceAndTheEndTakesLonger) {
  ButtonEvents events;
  const auto take = [&](const std::string& bytes, double now_s) {
    return events.take({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()},
                       std::llround(now_s * kSecond));
  };
  EXPECT_THAT(take(event(KEY_4, 1, EV_KEY, 5), 5), IsEmpty());
  EXPECT_THAT(take("", 5.6), IsEmpty());
  EXPECT_THAT(take("", 5.75), ElementsAre(KeyRequest{Kind::kPauseOrGoOn, ""}));
  EXPECT_THAT(take("", 6), IsEmpty());
  EXPECT_THAT(take(event(KEY_4, 0, EV_KEY, 7), 7), IsEmpty()) << "was heard of";
  EXPECT_THAT(take(press(KEY_5, 10, 1), 11), ElementsAre(KeyRequest{Kind::kQuiet, ""}));
  EXPECT_THAT(take(event(KEY_5, 1, EV_KEY, 20), 21.9), IsEmpty());
  EXPECT_THAT(take("", 22.1), ElementsAre(KeyRequest{Kind::kEnd, ""}));
  EXPECT_THAT(take(press(KEY_2, 30, 0.1), 32), ElementsAre(KeyRequest{Kind::kAround, ""}))
      << "was read late";
  EXPECT_THAT(take(event(KEY_5, 1, EV_KEY, 40) + event(SYN_DROPPED, 0, EV_SYN, 40), 43), IsEmpty())
      << "nobody knows that it is still held";
}

TEST(DeviceKeysTest, ReadsAnInputDevice) {
  const roomwise::testing::ScratchFolder folder;
  const auto fifo = folder / "event0";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  EXPECT_ERROR(DeviceKeys::open(-1, folder / "none"), "cannot be read");
  const auto keys = DeviceKeys::open(-1, fifo);
  ASSERT_OK(keys);
  std::FILE* buttons = std::fopen(fifo.c_str(), "w");
  ASSERT_NE(buttons, nullptr);
  const std::string bytes = press(KEY_2, 0, 0.1);
  std::fwrite(bytes.data(), 1, bytes.size(), buttons);
  std::fclose(buttons);
  std::vector<KeyRequest> heard;
  for (int i = 0; i < 100 && heard.empty(); ++i) heard = (*keys)->wait(100, 0);
  EXPECT_THAT(heard, ElementsAre(KeyRequest{Kind::kAround, ""}));
}

TEST(DeviceKeysTest, ButtonsThatWereGoneComeBack) {
  const roomwise::testing::ScratchFolder folder;
  const auto fifo = folder / "event0";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  const auto keys = DeviceKeys::open(-1, fifo).value();
  const auto press_2 = [&](TimestampNs now_ns) {
    std::FILE* buttons = std::fopen(fifo.c_str(), "w");
    ASSERT_NE(buttons, nullptr);
    const std::string bytes = press(KEY_2, 0, 0.1);
    std::fwrite(bytes.data(), 1, bytes.size(), buttons);
    std::fclose(buttons);  // unplugged
    EXPECT_THAT(keys->wait(1000, now_ns), ElementsAre(KeyRequest{Kind::kAround, ""}));
  };
  press_2(0);
  EXPECT_FALSE(keys->has_lost_buttons());
  EXPECT_THAT(keys->wait(1000, 0), IsEmpty());
  EXPECT_TRUE(keys->has_lost_buttons());
  std::filesystem::remove(fifo);
  EXPECT_THAT(keys->wait(0, 3 * kSecond), IsEmpty());
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  EXPECT_THAT(keys->wait(0, 4 * kSecond), IsEmpty());
  EXPECT_TRUE(keys->has_lost_buttons()) << "they are not looked for all the time";
  EXPECT_THAT(keys->wait(0, 5 * kSecond), IsEmpty());
  EXPECT_FALSE(keys->has_lost_buttons());
  press_2(6 * kSecond);
}

TEST(DeviceCredentialsTest, AreKeptForTheOwnerAlone) {
  const roomwise::testing::ScratchFolder folder;
  const auto file = folder / "config" / "roomwise" / "device.json";
  EXPECT_FALSE(stored_credentials(file, "flat.local:8443")->has_value());
  ASSERT_OK(store_credentials(file, "flat.local:8443", {"ab", "token"}));
  ASSERT_OK(store_credentials(file, "other.local:8443", {"cd", "other"}));
  const auto stored = stored_credentials(file, "flat.local:8443");
  ASSERT_OK(stored);
  ASSERT_TRUE(stored->has_value());
  EXPECT_EQ((*stored)->fingerprint, "ab");
  EXPECT_EQ((*stored)->token, "token");
  struct stat status {};
  ASSERT_EQ(::stat(file.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600u);
  ASSERT_OK(write_file(file, "{\"flat.local:8443\": 1}"));
  EXPECT_ERROR(stored_credentials(file, "flat.local:8443"), "pair again");
}

// A speaker that tells the end of what it speaks when the test says so.
class HeldSpeaker final : public speech::Speaker {
 public:
  [[nodiscard]] Expected<void> begin(const guide::Utterance& utterance, TimestampNs) override {
    heard += utterance.prompt.text + "\n";
    done = false;
    return {};
  }
  [[nodiscard]] Expected<void> stop(TimestampNs) override {
    heard += "(stop)\n";
    return {};
  }
  [[nodiscard]] Expected<bool> is_done(TimestampNs) override { return done; }

  std::string heard;
  bool done = false;
};

guide::Prompt answer(const std::string& key, const std::string& text, TimestampNs valid_until_ns) {
  guide::Prompt prompt;
  prompt.replace_key = key;
  prompt.text = text;
  prompt.valid_until_ns = valid_until_ns;
  return prompt;
}

class HeldVoiceTest : public ::testing::Test {
 protected:
  HeldVoiceTest() {
    auto speaker = std::make_unique<HeldSpeaker>();
    speaker_ = speaker.get();
    guide::Wording wording;
    wording.catalogue = &catalogue_;
    voice_ = std::make_unique<DeviceVoice>(std::move(speaker), wording);
  }
  void step_until(TimestampNs end_ns) {
    for (; now_ns_ <= end_ns; now_ns_ += kSecond / 10) ASSERT_OK(voice_->step(now_ns_));
  }

  guide::MessageCatalogue catalogue_ = guide::MessageCatalogue::built_in();
  HeldSpeaker* speaker_ = nullptr;
  std::unique_ptr<DeviceVoice> voice_;
  TimestampNs now_ns_ = 0;
};

TEST_F(HeldVoiceTest, ASpeakerThatNeverEndsIsNotWaitedFor) {
  // 10 characters, one of them of two bytes: 3 s + 2 * 0.6 s.
  voice_->say(answer("room", "Die Küche.", 3 * kSecond), 0, true);
  voice_->say(answer("later", "Later.", 60 * kSecond), 0, true);
  step_until(4 * kSecond + kSecond / 5);
  EXPECT_EQ(speaker_->heard, "Die Küche.\n");
  step_until(5 * kSecond);
  EXPECT_EQ(speaker_->heard, "Die Küche.\n(stop)\nLater.\n");
  step_until(20 * kSecond);
  EXPECT_TRUE(voice_->is_silent(20 * kSecond));
}

TEST_F(HeldVoiceTest, AskingAnewBreaksOffTheAnswer) {
  voice_->say(answer("around", "Bed.", 3 * kSecond), 0, true);
  voice_->say(answer("around/2", "Lamp.", 7 * kSecond), 0, true);
  step_until(kSecond);
  voice_->withdraw_answers(kSecond);
  step_until(kSecond + kSecond / 2);
  EXPECT_EQ(speaker_->heard, "Bed.\n(stop)\n");
  voice_->say(answer("room", "Kitchen.", 5 * kSecond), 2 * kSecond, true);
  step_until(2 * kSecond);
  EXPECT_EQ(speaker_->heard, "Bed.\n(stop)\nKitchen.\n");
}

TEST_F(HeldVoiceTest, AnAnswerThatComesTooLateIsTold) {
  voice_->say(answer("around", "Before you the bed.", 9 * kSecond), 0, true);
  step_until(0);
  voice_->say(answer("room", "Kitchen.", 2 * kSecond), kSecond, true);
  voice_->say(answer("other", "Other.", 2 * kSecond), kSecond, true);
  step_until(3 * kSecond);
  speaker_->done = true;
  step_until(4 * kSecond);
  speaker_->done = true;
  step_until(8 * kSecond);
  EXPECT_EQ(speaker_->heard, "Before you the bed.\nThat did not work. Please try again.\n");
}

TEST_F(HeldVoiceTest, WhoAsksAnewDoesNotHearThatTheAnswerBeforeCameTooLate) {
  voice_->answer("device.failed", guide::Sound::kUnsure, 0);
  step_until(kSecond);
  voice_->withdraw_answers(kSecond);
  voice_->say(answer("room", "Kitchen.", 3 * kSecond), kSecond, true);
  step_until(2 * kSecond);
  EXPECT_EQ(speaker_->heard, "That did not work. Please try again.\n(stop)\nKitchen.\n");
}

TEST_F(HeldVoiceTest, AnInstructionThatIsOldByNowIsPassedOverWithoutAWord) {
  voice_->say(answer("rooms", "I know five rooms.", 9 * kSecond), 0, true);
  step_until(0);
  voice_->say(answer("guide", "Turn left.", 2 * kSecond), kSecond, false);
  step_until(3 * kSecond);
  speaker_->done = true;
  step_until(6 * kSecond);
  EXPECT_EQ(speaker_->heard, "I know five rooms.\n");
}

TEST(DeviceVoiceTest, SpeaksByTheRules) {
  const auto catalogue = guide::MessageCatalogue::built_in();
  std::ostringstream heard;
  guide::Wording wording;
  wording.catalogue = &catalogue;
  DeviceVoice voice(std::make_unique<TextSpeaker>(heard), wording);
  service::PromptMessage message;
  message.replace_key = "room";
  message.message_id = "room.is";
  message.text = "You are in the kitchen.";
  message.language = "en";
  message.priority = "answer";
  message.confidence = "sure";
  message.sound = "answer";
  message.valid_until_t_ms = 5000;
  const auto prompt = service::prompt_of(message);
  ASSERT_OK(prompt);
  voice.say(*prompt, 0, true);
  voice.notice("device.connection_lost", guide::Sound::kLost, 0);
  for (TimestampNs now_ns = 0; now_ns < 2 * kSecond; now_ns += kSecond / 10) {
    ASSERT_OK(voice.step(now_ns));
  }
  EXPECT_TRUE(voice.is_silent(2 * kSecond));
  voice.say(*prompt, 6 * kSecond, true);  // too late
  ASSERT_OK(voice.step(6 * kSecond));
  EXPECT_EQ(heard.str(), "(answer) You are in the kitchen.\n(lost) The connection is lost.\n");
  ASSERT_OK(voice.step(7 * kSecond));
  EXPECT_THAT(heard.str(), ::testing::EndsWith("(unsure) That did not work. Please try again.\n"));
  message.priority = "urgent";
  EXPECT_ERROR(service::prompt_of(message), "'urgent'");
  EXPECT_ERROR(open_speaker("shout", 0, heard), "wav:FILE");
}

// Speaks so many prompts, then fails for good.
class DyingSpeaker final : public speech::Speaker {
 public:
  DyingSpeaker(std::ostream& heard, int prompts) : heard_(heard), prompts_(prompts) {}
  [[nodiscard]] Expected<void> begin(const guide::Utterance& utterance, TimestampNs) override {
    if (prompts_-- <= 0) return fail("the daemon is gone");
    heard_ << utterance.prompt.text << '\n';
    return {};
  }
  [[nodiscard]] Expected<void> stop(TimestampNs) override { return {}; }
  [[nodiscard]] Expected<bool> is_done(TimestampNs) override {
    return prompts_ >= 0 ? Expected<bool>(true) : fail("the daemon is gone");
  }

 private:
  std::ostream& heard_;
  int prompts_;
};

TEST(ReopenedSpeakerTest, SpeaksOnOnceTheSpeechIsBack) {
  std::ostringstream heard, errors;
  int opened = 0;
  const auto open = [&]() -> Expected<std::unique_ptr<speech::Speaker>> {
    if (++opened == 2) return fail("it is not back yet");
    return std::make_unique<DyingSpeaker>(heard, 1);
  };
  auto speaker = ReopenedSpeaker::open(open, errors);
  ASSERT_OK(speaker);
  const auto say = [&](const std::string& text, TimestampNs now_ns) {
    guide::Utterance utterance;
    utterance.prompt.text = text;
    EXPECT_OK((*speaker)->begin(utterance, now_ns));
    EXPECT_OK((*speaker)->is_done(now_ns));
    EXPECT_OK((*speaker)->stop(now_ns));
  };
  say("one", 0);
  say("two", kSecond);        // the speech is gone
  say("three", 2 * kSecond);  // too early to try
  say("four", 3 * kSecond);   // not back yet
  say("five", 4 * kSecond);
  EXPECT_EQ(opened, 2);
  say("six", 5 * kSecond);
  EXPECT_EQ(opened, 3);
  EXPECT_EQ(heard.str(), "one\nsix\n");
  EXPECT_EQ(errors.str(),
            "the speech failed and is opened again: the daemon is gone\nnot spoken: two\n"
            "not spoken: three\nnot spoken: four\nnot spoken: five\n");
  opened = 1;
  EXPECT_ERROR(ReopenedSpeaker::open(open, errors), "not back yet");
}

}  // namespace
}  // namespace roomwise::app
