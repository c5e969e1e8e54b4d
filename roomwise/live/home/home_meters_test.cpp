#include "roomwise/live/home/home_meters.h"

#include <gmock/gmock.h>

#include "roomwise/base/testing/testing.h"

namespace roomwise::live {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

class HomeMetersTest : public ::testing::Test {
 protected:
  [[nodiscard]] std::string written() const {
    service::MetricsText text;
    meters.write(text);
    return text.text();
  }

  std::vector<std::string> lines;
  HomeMeters meters{[this](std::string_view line) { lines.emplace_back(line); }};
};

TEST_F(HomeMetersTest, QuestionsAreTimedByTheirKind) {
  meters.answered(service::Question::kWhereAmI, 0.02);
  meters.answered(service::Question::kWhereAmI, 0.3);
  meters.looked(0.2, true);
  meters.looked(0.1, false);
  const std::string text = written();
  EXPECT_THAT(text, HasSubstr("question_seconds_bucket{question=\"where_am_i\",le=\"0.25\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("question_seconds_count{question=\"where_am_i\"} 2\n"));
  EXPECT_THAT(text, HasSubstr("roomwise_frame_seconds_count 2\n"));
  EXPECT_THAT(text, HasSubstr("roomwise_frames_failed_total 1\n"));
  EXPECT_THAT(lines, ElementsAre());
}

TEST_F(HomeMetersTest, DoNotTellThatSomebodyIsLed) {
  using service::Question;
  for (const Question question :
       {Question::kWayTo, Question::kTakeMeTo, Question::kTakeMeBack, Question::kGuide})
    meters.answered(question, 0.1);
  const std::string text = written();
  EXPECT_THAT(text, HasSubstr("question_seconds_count{question=\"way\"} 4\n"));
  for (const char* told : {"way_to", "take_me", "guide"}) EXPECT_THAT(text, Not(HasSubstr(told)));
}

TEST_F(HomeMetersTest, JobsAreCountedAndTold) {
  meters.on_job({"map", "running", "", ErrorCode::kFailed, 0});
  EXPECT_THAT(written(), HasSubstr("roomwise_job_running{job=\"map\"} 1\n"));
  meters.on_job({"map", "failed", "flat.home: the disk is full", ErrorCode::kDiskFull, 12});
  meters.on_job({"learn", "running", "", ErrorCode::kFailed, 0});
  meters.on_job({"learn", "done", "2 rooms learned", ErrorCode::kFailed, 3});
  const std::string text = written();
  EXPECT_THAT(text, HasSubstr("roomwise_job_running{job=\"map\"} 0\n"));
  EXPECT_THAT(text, HasSubstr("roomwise_jobs_total{job=\"map\",state=\"failed\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("roomwise_jobs_total{job=\"learn\",state=\"done\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("roomwise_failures_total{what=\"a job\",why=\"disk_full\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("roomwise_job_seconds_sum{job=\"map\"} 12\n"));
  EXPECT_THAT(
      lines,
      ElementsAre("job map: begun", "job map: failed after 12.0 s: flat.home: the disk is full",
                  "job learn: begun", "job learn: done after 3.0 s: 2 rooms learned"));
}

TEST_F(HomeMetersTest, DamageIsToldFromOtherFailures) {
  meters.failed("a picture", Error{"flat.home: is damaged", ErrorCode::kDamaged});
  meters.failed("a picture", Error{"there is no key-frame 9"});
  EXPECT_THAT(written(), HasSubstr("{what=\"a picture\",why=\"damaged\"} 1\n"));
  EXPECT_THAT(written(), HasSubstr("{what=\"a picture\",why=\"other\"} 1\n"));
  EXPECT_THAT(lines, ElementsAre("a picture failed: flat.home: is damaged",
                                 "a picture failed: there is no key-frame 9"));
}

TEST_F(HomeMetersTest, ADiskThatGetsFullIsToldOnce) {
  for (const std::uint64_t megabytes : {5000U, 900U, 800U, 6000U}) {
    meters.disk(megabytes * 1'000'000);
  }
  EXPECT_THAT(lines, ElementsAre("the disk is nearly full: 900 MB are left; free some space",
                                 "the disk has space again: 6000 MB"));
  EXPECT_THAT(written(), HasSubstr("roomwise_disk_free_bytes 6000000000\n"));
}

}  // namespace
}  // namespace roomwise::live
