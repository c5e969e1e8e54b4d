#include "terminal_progress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace roomwise::app {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

// A progress whose clock the test moves and whose output it reads.
class TerminalProgressTest : public ::testing::Test {
 protected:
  std::unique_ptr<TerminalProgress> make(bool is_terminal, int columns = 80) {
    return std::make_unique<TerminalProgress>(
        TerminalProgress::Output{[this](std::string_view text) { written_.emplace_back(text); },
                                 is_terminal, columns},
        [this] { return now_; }, [this] { return interrupted_; });
  }

  TimeLeft::Time now_{};
  bool interrupted_ = false;
  std::vector<std::string> written_;
};

TEST(TimeLeft, IsUnknownBeforeTheFirstUnitIsDone) {
  TimeLeft left;
  left.start({});
  EXPECT_EQ(left.seconds(100), std::nullopt);
  left.update(TimeLeft::Time{} + seconds(5), 0);
  EXPECT_EQ(left.seconds(100), std::nullopt);
}

TEST(TimeLeft, IsSteadyWherePartsAreOfUnequalLength) {
  TimeLeft left;
  TimeLeft::Time now{};
  left.start(now);
  std::uint64_t done = 0;
  double last_s = 0;
  // Every fourth takes nine seconds, the others one: three seconds in the mean.
  for (int part = 0; part < 60; ++part) {
    left.update(now += seconds(part % 4 == 3 ? 9 : 1), ++done);
    const double left_s = *left.seconds(100);
    if (part > 20) {
      EXPECT_NEAR(left_s, last_s, 0.15 * last_s) << part;
    }
    last_s = left_s;
  }
  EXPECT_NEAR(last_s, 3 * 40, 1e-9);
  EXPECT_EQ(left.seconds(done), 0.0);
}

TEST(TimeLeft, OfWorkThatGoesOnIsBySpeedOfNow) {
  TimeLeft left;
  TimeLeft::Time now{};
  left.start(now);
  left.update(now += milliseconds(10), 500);  // done before it was stopped
  left.update(now += seconds(10), 510);
  EXPECT_NEAR(*left.seconds(520), 10, 1e-9);
}

TEST(TimeLeft, IsExactAtAnyRateOfUpdates) {
  TimeLeft left;
  TimeLeft::Time now{};
  left.start(now);
  for (std::uint64_t done = 1; done <= 30000; ++done) left.update(now += milliseconds(1), done);
  EXPECT_NEAR(*left.seconds(31000), 1.0, 0.05);
}

TEST(FormatDuration, HasHoursOnlyWhereNeeded) {
  EXPECT_EQ(format_duration(0), "0:00");
  EXPECT_EQ(format_duration(59.6), "1:00");
  EXPECT_EQ(format_duration(754), "12:34");
  EXPECT_EQ(format_duration(3723), "1:02:03");
}

TEST_F(TerminalProgressTest, RewritesOneLineOnATerminal) {
  auto progress = make(true);
  progress->begin("mapping", 200);
  now_ += seconds(10);
  progress->advance(50, "7 key-frames");
  EXPECT_THAT(written_.back(), StartsWith("\rmapping [######......"));
  EXPECT_THAT(written_.back(), HasSubstr(" 25 % 50/200, 0:30 left, 7 key-frames"));
  now_ += seconds(30);
  progress->advance(200, "28 key-frames");
  progress->end();
  EXPECT_EQ(written_.back(), "\rmapping: 200 in 0:40, 28 key-frames\x1b[K\n");
  for (std::size_t i = 0; i + 1 < written_.size(); ++i) {
    EXPECT_THAT(written_[i], Not(HasSubstr("\n")));
  }
}

TEST_F(TerminalProgressTest, NeverWrapsALine) {
  auto progress = make(true, 30);
  progress->begin("mapping", 200);
  now_ += seconds(1);
  progress->advance(50, std::string(200, 'x'));
  EXPECT_EQ(written_.back().size(), 29 + std::string("\r\x1b[K").size());
}

TEST_F(TerminalProgressTest, DrawsAtMostTenTimesASecond) {
  auto progress = make(true);
  progress->begin("mapping", 1000);
  for (std::uint64_t done = 1; done <= 1000; ++done) {
    now_ += milliseconds(1);
    progress->advance(done, "");
  }
  EXPECT_LE(written_.size(), 11U);
}

TEST_F(TerminalProgressTest, LeavesTheLineOfWorkThatFailed) {
  auto progress = make(true);
  progress->begin("mapping", 10);
  progress.reset();
  EXPECT_EQ(written_.back(), "\n");
}

TEST_F(TerminalProgressTest, WritesAPlainLineEveryTenthInALog) {
  auto progress = make(false);
  progress->begin("mapping", 100);
  for (std::uint64_t done = 1; done <= 30; ++done) {
    now_ += milliseconds(500);
    progress->advance(done, "");
  }
  EXPECT_THAT(written_, ElementsAre("mapping: 10 %, 10/100, 0:45 left\n",
                                    "mapping: 20 %, 20/100, 0:40 left\n",
                                    "mapping: 30 %, 30/100, 0:35 left\n"));
}

TEST_F(TerminalProgressTest, WritesAPlainLineEveryTenSecondsOfSlowOrEndlessWork) {
  auto progress = make(false);
  progress->begin("recording", std::nullopt);
  for (std::uint64_t done = 1; done <= 25; ++done) {
    now_ += seconds(1);
    progress->advance(done, "room kitchen");
  }
  progress->end();
  EXPECT_THAT(written_,
              ElementsAre("recording: 10, room kitchen\n", "recording: 20, room kitchen\n",
                          "recording: 25 in 0:25, room kitchen\n"));
}

TEST_F(TerminalProgressTest, SaysOnceInALogThatAllIsDone) {
  auto progress = make(false);
  progress->begin("mapping", 2);
  now_ += seconds(20);
  progress->advance(2, "");
  progress->end();
  progress->begin("loading", 0);
  progress->end();
  EXPECT_THAT(written_, ElementsAre("mapping: 2 in 0:20\n"));
}

TEST_F(TerminalProgressTest, DoesNotFloodALogWithQuickWork) {
  auto progress = make(false);
  progress->begin("mapping", 100);
  for (std::uint64_t done = 1; done <= 100; ++done) progress->advance(done, "");
  progress->end();
  EXPECT_THAT(written_, ElementsAre("mapping: 100 in under a second\n"));
}

TEST_F(TerminalProgressTest, TellsTheWorkThatTheUserWantsToStop) {
  const auto progress = make(false);
  EXPECT_FALSE(progress->interrupted());
  interrupted_ = true;
  EXPECT_TRUE(progress->interrupted());
}

}  // namespace
}  // namespace roomwise::app
