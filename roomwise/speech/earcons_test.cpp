#include "roomwise/speech/earcons.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/speech/testing/test_sounds.h"

namespace roomwise::speech {
namespace {

using guide::Sound;
using testing::part;
using testing::strength;

constexpr int kToneRate_hz = 22050;
constexpr Sound kSounds[] = {Sound::kAnswer, Sound::kUnsure, Sound::kLost, Sound::kBack,
                             Sound::kAlert};

TEST(EarconsTest, AreShortAndHeardAndDoNotClick) {
  for (const Sound sound : kSounds) {
    const Pcm pcm = earcon(sound, kToneRate_hz);
    EXPECT_GT(pcm.duration_s(), 0.1);
    EXPECT_LT(pcm.duration_s(), 0.5);
    EXPECT_GT(testing::loudness(pcm.samples), 3000);
    EXPECT_LT(std::abs(pcm.samples.front()), 100);
    EXPECT_LT(std::abs(pcm.samples.back()), 300);
    for (const std::int16_t sample : pcm.samples) EXPECT_LT(std::abs(sample), 20000);
  }
  EXPECT_TRUE(earcon(Sound::kNone, kToneRate_hz).samples.empty());
}

TEST(EarconsTest, HaveTheTonesThatAreMeant) {
  const Pcm answer = earcon(Sound::kAnswer, kToneRate_hz);
  EXPECT_GT(strength(part(answer, 0, 0.07), 659.3), 5 * strength(part(answer, 0, 0.07), 987.8));
  EXPECT_GT(strength(part(answer, 0.07, 0.18), 987.8),
            5 * strength(part(answer, 0.07, 0.18), 659.3));
  const Pcm alert = earcon(Sound::kAlert, kToneRate_hz);
  EXPECT_GT(strength(alert, 1568), 10 * strength(alert, 800));
}

TEST(EarconsTest, LostFallsAndBackRises) {
  const auto rises = [](const Pcm& pcm) {
    const Pcm first = part(pcm, 0, 0.1);
    const Pcm last = part(pcm, 0.2, 0.36);
    return strength(last, 587.3) > strength(last, 293.7) &&
           strength(first, 293.7) > strength(first, 587.3);
  };
  EXPECT_TRUE(rises(earcon(Sound::kBack, kToneRate_hz)));
  EXPECT_FALSE(rises(earcon(Sound::kLost, kToneRate_hz)));
}

TEST(EarconsTest, AllDiffer) {
  for (const Sound a : kSounds) {
    for (const Sound b : kSounds) {
      EXPECT_EQ(a == b, earcon(a, kToneRate_hz).samples == earcon(b, kToneRate_hz).samples);
    }
  }
}

}  // namespace
}  // namespace roomwise::speech
