#include "roomwise/speech/espeak.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <thread>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/speech/testing/test_sounds.h"

namespace roomwise::speech {
namespace {

using ::testing::HasSubstr;

TEST(EspeakTest, SpeaksAndLongerTextsTakeLonger) {
  const auto text = synthesize("You are in the kitchen.", "en", 175);
  ASSERT_OK(text);
  EXPECT_EQ(text->rate_hz, 22050);
  EXPECT_GT(text->duration_s(), 0.8);
  EXPECT_LT(text->duration_s(), 4);
  EXPECT_GT(testing::loudness(text->samples), 500);
  const auto longer =
      synthesize("You are in the kitchen, and the bed is in the bedroom.", "en", 175);
  ASSERT_OK(longer);
  EXPECT_GT(longer->samples.size(), text->samples.size() * 3 / 2);
}

TEST(EspeakTest, FasterSpeechIsShorter) {
  const auto slow = synthesize("The microwave is at two o'clock, three steps.", "en", 120);
  const auto fast = synthesize("The microwave is at two o'clock, three steps.", "en", 300);
  ASSERT_OK(slow);
  ASSERT_OK(fast);
  EXPECT_LT(fast->duration_s(), slow->duration_s() * 0.6);
}

TEST(EspeakTest, GermanIsAnotherVoiceAndUmlautsAreHeard) {
  const auto german = synthesize("Die Küche", "de", 175);
  const auto english = synthesize("Die Küche", "en", 175);
  const auto plain = synthesize("Die Kuche", "de", 175);
  ASSERT_OK(german);
  ASSERT_OK(english);
  ASSERT_OK(plain);
  EXPECT_NE(german->samples, english->samples);
  EXPECT_NE(german->samples, plain->samples);
}

TEST(EspeakTest, MarkupIsSpokenAsText) {
  const auto less = synthesize("a <b> c", "en", 175);
  const auto nothing = synthesize("a c", "en", 175);
  ASSERT_OK(less);
  ASSERT_OK(nothing);
  EXPECT_GT(less->samples.size(), nothing->samples.size());
}

TEST(EspeakTest, AnEmptyTextIsSilent) {
  const auto empty = synthesize("", "en", 175);
  ASSERT_OK(empty);
  EXPECT_LT(testing::loudness(empty->samples), 1);
}

TEST(EspeakTest, SaysWhatIsWrong) {
  EXPECT_ERROR(synthesize("a", "no-such-language", 175), "no voice \"no-such-language\"");
  EXPECT_ERROR(synthesize("a", "en", 20), "20 words a minute; expected 80 to 450");
  EXPECT_ERROR(synthesize("a", "en", 900), "expected 80 to 450");
}

TEST(EspeakTest, IsStartedOnceForAPromptOfALanguageThatWasSpokenBefore) {
  const roomwise::testing::ScratchFolder folder;
  const std::string before = ::getenv("PATH");
  ASSERT_OK(write_file(folder / "espeak-ng",
                       fmt::format("#!/bin/sh\necho \"$1\" >> {}\nPATH={} exec espeak-ng \"$@\"\n",
                                   (folder / "started").string(), before)));
  std::filesystem::permissions(folder / "espeak-ng", std::filesystem::perms::owner_all);
  ::setenv("PATH", fmt::format("{}:{}", folder.path().string(), before).c_str(), 1);
  for (int i = 0; i < 3; ++i) EXPECT_OK(synthesize("yksi", "fi", 175));
  for (int i = 0; i < 2; ++i) EXPECT_ERROR(synthesize("a", "no-such-language", 175), "no voice");
  ::setenv("PATH", before.c_str(), 1);
  EXPECT_EQ(read_text_file(folder / "started").value(),
            "--voices=fi\n-v\n-v\n-v\n--voices=no-such-language\n--voices=no-such-language\n");
}

TEST(EspeakTest, ThreadsTakeTurns) {
  std::vector<std::thread> threads;
  std::vector<Pcm> sounds(4);
  for (std::size_t i = 0; i < sounds.size(); ++i) {
    threads.emplace_back([&sounds, i] {
      sounds[i] = synthesize(i % 2 == 0 ? "kitchen" : "Küche", i % 2 == 0 ? "en" : "de", 175)
                      .value_or(Pcm{});
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < sounds.size(); ++i) {
    EXPECT_GT(testing::loudness(sounds[i].samples), 500);
  }
}

}  // namespace
}  // namespace roomwise::speech
