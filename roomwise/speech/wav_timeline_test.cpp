#include "roomwise/speech/wav_timeline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "roomwise/base/testing/testing.h"
#include "roomwise/speech/testing/test_sounds.h"

namespace roomwise::speech {
namespace {

using roomwise::testing::ScratchFolder;
using ::testing::Each;
using ::testing::ElementsAreArray;
using ::testing::HasSubstr;
using testing::read_wav;

constexpr int kRate_hz = 8000;
using testing::kSecond;
constexpr TimestampNs kBegin = 7 * kSecond;

Pcm tone(double hz, double duration_s) {
  Pcm pcm{kRate_hz, {}};
  for (int i = 0; i < duration_s * kRate_hz; ++i) {
    pcm.samples.push_back(
        static_cast<std::int16_t>(9000 * std::sin(2 * std::numbers::pi * hz * i / kRate_hz)));
  }
  return pcm;
}

class WavTimelineTest : public ::testing::Test {
 protected:
  [[nodiscard]] WavTimeline create() const {
    return WavTimeline::create(path_, kBegin, kRate_hz).value();
  }
  ScratchFolder folder_;
  std::filesystem::path path_ = folder_ / "walk.wav";
};

TEST_F(WavTimelineTest, ASoundAsBytesIsAWavFile) {
  const Pcm pcm = tone(440, 0.5);
  const auto bytes = wav_bytes(pcm);
  EXPECT_EQ(bytes.size(), 44 + 2 * pcm.samples.size());
  const auto read = read_wav(bytes);
  ASSERT_OK(read);
  EXPECT_EQ(read->rate_hz, kRate_hz);
  EXPECT_EQ(read->samples, pcm.samples);
  EXPECT_GT(testing::strength(*read, 440), 100 * testing::strength(*read, 523));
}

TEST_F(WavTimelineTest, SoundsStandWhereTheyWereHeard) {
  WavTimeline timeline = create();
  const Pcm first = tone(440, 0.5);
  const Pcm second = tone(880, 0.25);
  ASSERT_OK(timeline.place(kBegin + kSecond / 4, first));
  ASSERT_OK(timeline.place(kBegin + 2 * kSecond, second));
  const auto read = read_wav(path_);
  ASSERT_OK(read);
  ASSERT_EQ(read->samples.size(), 18000u);
  EXPECT_THAT(testing::part(*read, 0, 0.25).samples, Each(0));
  EXPECT_EQ(testing::part(*read, 0.25, 0.75).samples, first.samples);
  EXPECT_THAT(testing::part(*read, 0.75, 2).samples, Each(0));
  EXPECT_EQ(testing::part(*read, 2, 2.25).samples, second.samples);
  EXPECT_DOUBLE_EQ(timeline.duration_s(), 2.25);
}

TEST_F(WavTimelineTest, ALaterSoundBreaksTheEarlierOff) {
  WavTimeline timeline = create();
  const Pcm first = tone(440, 2);
  const Pcm second = tone(880, 0.25);
  ASSERT_OK(timeline.place(kBegin, first));
  ASSERT_OK(timeline.place(kBegin + kSecond / 2, second));
  auto read = read_wav(path_);
  ASSERT_OK(read);
  EXPECT_DOUBLE_EQ(read->duration_s(), 0.75);
  EXPECT_EQ(testing::part(*read, 0, 0.5).samples, testing::part(first, 0, 0.5).samples);
  EXPECT_EQ(testing::part(*read, 0.5, 0.75).samples, second.samples);
  ASSERT_OK(timeline.cut(kBegin + kSecond / 4));
  ASSERT_OK(timeline.cut(kBegin + kSecond));  // there is nothing
  ASSERT_OK(timeline.extend(kBegin + kSecond));
  ASSERT_OK(timeline.extend(kBegin + kSecond / 8));
  read = read_wav(path_);
  ASSERT_OK(read);
  EXPECT_DOUBLE_EQ(read->duration_s(), 1);
  EXPECT_THAT(testing::part(*read, 0.25, 1).samples, Each(0));
}

TEST_F(WavTimelineTest, SaysWhatIsWrong) {
  EXPECT_ERROR(WavTimeline::create(folder_ / "no" / "a.wav", kBegin, kRate_hz), "No such file");
  EXPECT_ERROR(WavTimeline::create(path_, kBegin, 1), "rate_hz is 1");
  ASSERT_OK(write_file(folder_ / "letter.txt", "Dear reader"));
  EXPECT_ERROR(WavTimeline::create(folder_ / "letter.txt", kBegin, kRate_hz), "no WAV file");
  WavTimeline timeline = create();
  EXPECT_ERROR(timeline.place(kBegin - kSecond, tone(440, 0.1)), "1 s before its beginning");
  EXPECT_ERROR(timeline.place(kBegin, Pcm{22050, {1, 2}}), "a sound of 22050 Hz");
  EXPECT_ERROR(timeline.place(kBegin + 400'000 * kSecond, tone(440, 0.1)), "holds 4 GB");
  EXPECT_OK(read_wav(path_));
}

TEST_F(WavTimelineTest, AnOldRecordingIsOverwritten) {
  ASSERT_OK(create().place(kBegin, tone(440, 1)));
  const WavTimeline timeline = create();
  EXPECT_EQ(read_wav(path_).value().samples.size(), 0u);
}

// A child writes one sound after the other and is killed without a warning, at whatever it does.
TEST_F(WavTimelineTest, AKilledProgramLeavesAReadableFile) {
  for (int round = 0; round < 5; ++round) {
    int pipe_ends[2];
    ASSERT_EQ(pipe(pipe_ends), 0);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      WavTimeline timeline = create();
      const Pcm sound = tone(440, 0.05);
      for (TimestampNs now = kBegin;; now += kSecond / 10) {
        if (!timeline.place(now, sound)) _exit(1);
        if (write(pipe_ends[1], "x", 1) != 1) _exit(1);
      }
    }
    // It has written so many sounds when it is killed.
    const int sounds = 20 + 7 * round;
    char sign = 0;
    for (int i = 0; i < sounds; ++i) ASSERT_EQ(::read(pipe_ends[0], &sign, 1), 1);
    kill(child, SIGKILL);
    int status = 0;
    waitpid(child, &status, 0);
    close(pipe_ends[0]);
    close(pipe_ends[1]);
    ASSERT_TRUE(WIFSIGNALED(status));
    const auto read = read_wav(path_);
    ASSERT_OK(read);
    EXPECT_GE(read->duration_s(), 0.1 * (sounds - 1) + 0.05 - 1e-9);
    EXPECT_EQ(testing::part(*read, 1, 1.05).samples, tone(440, 0.05).samples);
  }
}

}  // namespace
}  // namespace roomwise::speech
