#include "roomwise/speech/recorded_speaker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/speech/earcons.h"
#include "roomwise/speech/espeak.h"
#include "roomwise/speech/testing/test_sounds.h"

namespace roomwise::speech {
namespace {

using roomwise::testing::ScratchFolder;
using ::testing::Each;
using ::testing::HasSubstr;

// espeak-ng does not say a text twice to the bit, nor in quite the same time.
constexpr double kVaries_s = 0.02;
using testing::kSecond;

guide::Utterance utterance(const std::string& text, guide::Sound sound) {
  guide::Utterance made;
  made.prompt.text = text;
  made.prompt.language = "en";
  made.prompt.sound = sound;
  return made;
}

class RecordedSpeakerTest : public ::testing::Test {
 protected:
  [[nodiscard]] RecordedSpeaker speaker() const {
    return {WavTimeline::create(path_, 0, RecordedSpeaker::kRate_hz).value(), 175};
  }
  [[nodiscard]] Pcm recorded() const { return testing::read_wav(path_).value(); }

  ScratchFolder folder_;
  std::filesystem::path path_ = folder_ / "walk.wav";
};

TEST_F(RecordedSpeakerTest, TheSoundComesBeforeTheWords) {
  const auto utterance_ = utterance("Kitchen.", guide::Sound::kUnsure);
  const Pcm words = synthesize("Kitchen.", "en", 175).value();
  const Pcm tones = earcon(guide::Sound::kUnsure, words.rate_hz);
  const auto pcm = spoken(utterance_.prompt, 175);
  ASSERT_OK(pcm);
  ASSERT_GT(pcm->samples.size(), tones.samples.size() + words.samples.size());
  EXPECT_EQ(testing::part(*pcm, 0, tones.duration_s()).samples, tones.samples);
  EXPECT_NEAR(pcm->duration_s(), tones.duration_s() + 0.08 + words.duration_s(), kVaries_s);
}

TEST_F(RecordedSpeakerTest, IsDoneWhenTheWordsWouldHaveBeenHeard) {
  RecordedSpeaker speaker = this->speaker();
  EXPECT_TRUE(speaker.is_done(0).value());
  const auto said = utterance("You are in the kitchen.", guide::Sound::kAnswer);
  ASSERT_OK(speaker.begin(said, 3 * kSecond));
  EXPECT_FALSE(speaker.is_done(3 * kSecond + kSecond / 2).value());
  const double duration_s = spoken(said.prompt, 175).value().duration_s();
  EXPECT_NEAR(seconds_between(3 * kSecond, speaker.done_ns()), duration_s, kVaries_s);
  EXPECT_TRUE(speaker.is_done(speaker.done_ns()).value());
  EXPECT_NEAR(recorded().duration_s(), 3 + duration_s, kVaries_s);
  EXPECT_THAT(testing::part(recorded(), 0, 3).samples, Each(0));
}

TEST_F(RecordedSpeakerTest, ANewUtteranceBreaksTheOldOff) {
  RecordedSpeaker speaker = this->speaker();
  ASSERT_OK(speaker.begin(utterance("The bed is far away from here.", guide::Sound::kNone), 0));
  const auto hazard = utterance("Obstacle ahead.", guide::Sound::kAlert);
  ASSERT_OK(speaker.begin(hazard, kSecond / 2));
  EXPECT_NEAR(recorded().duration_s(), 0.5 + spoken(hazard.prompt, 175).value().duration_s(),
              kVaries_s);
  ASSERT_OK(speaker.stop(kSecond));
  EXPECT_TRUE(speaker.is_done(kSecond).value());
  EXPECT_DOUBLE_EQ(recorded().duration_s(), 1);
}

TEST_F(RecordedSpeakerTest, TellsOfALanguageWithoutAVoice) {
  RecordedSpeaker speaker = this->speaker();
  auto unknown = utterance("a", guide::Sound::kNone);
  unknown.prompt.language = "xx";
  EXPECT_ERROR(speaker.begin(unknown, 0), "no voice \"xx\"");
}

}  // namespace
}  // namespace roomwise::speech
