#include "roomwise/speech/speech_dispatcher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>
#include <semaphore>
#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#endif

#include "roomwise/base/testing/testing.h"
#include "roomwise/speech/earcons.h"
#include "roomwise/speech/testing/test_sounds.h"
#include "roomwise/speech/testing/test_ssip_server.h"

namespace roomwise::speech {
namespace {

using roomwise::testing::ScratchFolder;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

guide::Utterance utterance(const std::string& text, const std::string& language,
                           guide::Priority priority = guide::Priority::kAnswer,
                           guide::Sound sound = guide::Sound::kNone) {
  guide::Utterance made;
  made.prompt.text = text;
  made.prompt.language = language;
  made.prompt.priority = priority;
  made.prompt.sound = sound;
  return made;
}

class SpeechDispatcherTest : public ::testing::Test {
 protected:
  void SetUp() override {
#ifdef __SANITIZE_THREAD__
    GTEST_SKIP() << "libspeechd cancels its thread at the end and takes its locks away without "
                    "waiting for it, which ThreadSanitizer reports, or does not survive";
#endif
  }
  [[nodiscard]] Expected<std::unique_ptr<SpeechDispatcher>> open() {
    return SpeechDispatcher::open({.address = server_.address(), .may_start_daemon = false},
                                  [this] { ends_.release(); });
  }

  ScratchFolder folder_;
  testing::SsipServer server_{folder_ / "speechd.sock"};
  std::counting_semaphore<> ends_{0};
};

TEST_F(SpeechDispatcherTest, SpeaksAndHearsOfTheEnd) {
  auto speaker = open();
  ASSERT_OK(speaker);
  EXPECT_TRUE((*speaker)->is_done(0).value());
  ASSERT_OK((*speaker)->begin(utterance("Sie sind in der Küche.", "de"), 0));
  EXPECT_FALSE((*speaker)->is_done(0).value());
  server_.end(1);
  ends_.acquire();
  EXPECT_TRUE((*speaker)->is_done(0).value());
  const auto lines = server_.lines();
  EXPECT_THAT(lines, Contains("SET SELF LANGUAGE de"));
  EXPECT_THAT(lines, Contains("SET SELF PRIORITY MESSAGE"));
  EXPECT_THAT(lines, Contains("SET SELF SSML_MODE on"));
  EXPECT_THAT(lines, Contains("<speak>Sie sind in der Küche.</speak>"));
}

TEST_F(SpeechDispatcherTest, TheSoundGoesAlongInTheMessage) {
  auto speaker = open();
  ASSERT_OK(speaker);
  ASSERT_OK((*speaker)->begin(
      utterance("Obstacle ahead.", "en", guide::Priority::kHazard, guide::Sound::kAlert), 0));
  const auto lines = server_.lines();
  EXPECT_THAT(lines, Contains("SET SELF PRIORITY IMPORTANT"));
  const auto message = std::ranges::find_if(
      lines, [](const auto& line) { return line.starts_with("<speak><audio"); });
  ASSERT_NE(message, lines.end());
  EXPECT_TRUE(message->ends_with("\"/>Obstacle ahead.</speak>"));
  const std::size_t begin = message->find('"') + 1;
  const std::filesystem::path file = message->substr(begin, message->find('"', begin) - begin);
  const auto sound = testing::read_wav(file);
  ASSERT_OK(sound);
  EXPECT_EQ(sound->samples, earcon(guide::Sound::kAlert, sound->rate_hz).samples);
  speaker->reset();
  EXPECT_FALSE(std::filesystem::exists(file));
}

TEST_F(SpeechDispatcherTest, ANewUtteranceCancelsTheOldAndItsEndDoesNotCount) {
  auto speaker = open();
  ASSERT_OK(speaker);
  ASSERT_OK((*speaker)->begin(utterance("First.", "en"), 0));
  ASSERT_OK((*speaker)->begin(utterance("Second.", "en"), 0));
  EXPECT_THAT(server_.lines(), Contains("CANCEL SELF"));
  ends_.acquire();  // that of the first
  EXPECT_FALSE((*speaker)->is_done(0).value());
  server_.end(2);
  ends_.acquire();
  EXPECT_TRUE((*speaker)->is_done(0).value());
  ASSERT_OK((*speaker)->begin(utterance("Third.", "en"), 0));
  ASSERT_OK((*speaker)->stop(0));
  EXPECT_TRUE((*speaker)->is_done(0).value());
  const auto lines = server_.lines();
  EXPECT_EQ(std::ranges::count(lines, "SET SELF LANGUAGE en"), 1);
}

TEST_F(SpeechDispatcherTest, OneSpeakerAProcess) {
  auto speaker = open();
  ASSERT_OK(speaker);
  EXPECT_ERROR(open(), "already");
}

TEST_F(SpeechDispatcherTest, ALanguageThatIsNotTakenIsAnError) {
  auto speaker = open();
  ASSERT_OK(speaker);
  EXPECT_ERROR((*speaker)->begin(utterance("a", "xx"), 0), "the language \"xx\"");
}

TEST_F(SpeechDispatcherTest, ADaemonThatIsGoneIsAnError) {
  auto speaker = open();
  ASSERT_OK(speaker);
  ASSERT_OK((*speaker)->begin(utterance("First.", "en"), 0));
  server_.hang_up();
  EXPECT_ERROR((*speaker)->is_done(0), "speech-dispatcher has ended");
  EXPECT_ERROR((*speaker)->begin(utterance("Second.", "en"), 0), "apt-get install");
}

TEST(SpeechDispatcherWithoutDaemonTest, NamesWhatToInstall) {
#ifdef __SANITIZE_ADDRESS__
  const __lsan::ScopedDisabler disabler;  // libspeechd's own: spd_open2() leaks what it refuses
#endif
  const ScratchFolder folder;
  const auto speaker = SpeechDispatcher::open(
      {.address = "unix_socket:" + (folder / "nothing").string(), .may_start_daemon = false});
  EXPECT_ERROR(speaker, "apt-get install speech-dispatcher");
  EXPECT_ERROR(SpeechDispatcher::open({.address = "nonsense:1", .may_start_daemon = false}),
               "SPEECHD_ADDRESS");
}

TEST(SsmlTest, SignsAreHarmless) {
  EXPECT_EQ(ssml_of("a<b> & \"c\"\r\n.", ""), "<speak>a&lt;b&gt; &amp; &quot;c&quot;  .</speak>");
  EXPECT_EQ(ssml_of("a", "/tmp/x.wav"), "<speak><audio src=\"/tmp/x.wav\"/>a</speak>");
}

}  // namespace
}  // namespace roomwise::speech
