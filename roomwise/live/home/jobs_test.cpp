#include "roomwise/live/home/jobs.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <future>
#include <ranges>
#include <system_error>
#include <vector>

#include "roomwise/base/testing/testing.h"

namespace roomwise::live {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

struct Told {
  std::mutex mutex;
  std::vector<service::JobState> states;

  void operator()(const service::JobState& state) {
    const std::scoped_lock lock(mutex);
    states.push_back(state);
  }
};

TEST(Jobs, TellWhatIsDoneAndWhatCameOfIt) {
  Told told;
  Jobs jobs(std::ref(told));
  EXPECT_FALSE(jobs.state());
  ASSERT_OK(jobs.start("map", [](Progress& progress) -> Expected<JobEnd> {
    progress.begin("mapping", 4);
    progress.advance(1, "one");
    progress.begin("fusing", 2);
    return JobEnd{"all well", "mapped", {{"placed", 7}}};
  }));
  jobs.wait();
  const auto last = jobs.state();
  ASSERT_TRUE(last);
  EXPECT_EQ(last->kind, "map");
  EXPECT_EQ(last->state, "done");
  EXPECT_EQ(last->text, "all well");
  EXPECT_EQ(last->message, "mapped");
  EXPECT_EQ(last->values.at("placed"), 7);
  EXPECT_EQ(last->fraction, 1);
  std::vector<std::string> stages;
  const std::scoped_lock lock(told.mutex);  // it may be told still that the job is done
  for (const service::JobState& state : told.states) {
    if (stages.empty() || stages.back() != state.stage) stages.push_back(state.stage);
  }
  EXPECT_THAT(stages, ::testing::IsSupersetOf({"mapping", "fusing"}));
}

TEST(Jobs, AreOneWholeThatNeverGoesBack) {
  Told told;
  Jobs jobs(std::ref(told));
  ASSERT_OK(jobs.start("map", [](JobProgress& progress) -> Expected<JobEnd> {
    for (std::size_t round = 0; round < 2; ++round) {
      progress.begin_round(round, 2);
      for (const char* work : {"loading the map", "mapping", "loading the map", "what is no step",
                               "fusing the map", "looking for what was taught"}) {
        progress.begin(work, 2);
        progress.advance(2, "");
      }
    }
    return fail("not to be told as done");
  }));
  jobs.wait();
  std::vector<double> begun_at;
  const std::scoped_lock lock(told.mutex);
  for (const service::JobState& state : told.states) {
    if (state.state == "running") begun_at.push_back(state.fraction);
  }
  EXPECT_TRUE(std::ranges::is_sorted(begun_at)) << ::testing::PrintToString(begun_at);
  const auto at = std::ranges::find(told.states | std::views::reverse, "loading the map",
                                    &service::JobState::stage);
  ASSERT_NE(at, told.states.rend());
  EXPECT_GT(at->fraction, 0.5) << "the second round";
  EXPECT_LT(at->fraction, 0.7);
  const auto mapping = std::ranges::find(told.states, "mapping", &service::JobState::stage);
  ASSERT_NE(mapping, told.states.end());
  EXPECT_GT(mapping->fraction, 0) << "it is not the first step";
  EXPECT_LT(mapping->fraction, 0.5) << "nor the last";
}

TEST(Jobs, OneAtATime) {
  Jobs jobs([](const service::JobState&) {});
  std::promise<void> go;
  ASSERT_OK(jobs.start("learn", [&](Progress&) -> Expected<JobEnd> {
    go.get_future().wait();
    return JobEnd{};
  }));
  EXPECT_TRUE(jobs.running());
  EXPECT_ERROR(jobs.start("map", [](Progress&) -> Expected<JobEnd> { return JobEnd{}; }), "learn");
  EXPECT_FALSE(jobs.stop("map")) << "another is running";
  go.set_value();
  jobs.wait();
  EXPECT_OK(jobs.start("map", [](Progress&) -> Expected<JobEnd> { return JobEnd{}; }));
}

TEST(Jobs, WhatIsToFollowBeginsWhenNothingElseRuns) {
  std::vector<std::string> done;  // on the jobs' one thread
  std::promise<void> go;
  const auto note = [&](const char* what) {
    return [&done, what](Progress& progress) -> Expected<JobEnd> {
      EXPECT_FALSE(progress.interrupted()) << what << " is not what was stopped";
      done.emplace_back(what);
      return JobEnd{};
    };
  };
  Told told;
  {
    Jobs jobs(std::ref(told));
    ASSERT_OK(jobs.start_next("prepare", [&](Progress& progress) -> Expected<JobEnd> {
      while (!progress.interrupted()) std::this_thread::yield();
      return fail_with(ErrorCode::kInterrupted, "stopped");
    }));
    ASSERT_OK(jobs.start_next("erase", [&](Progress& progress) {
      go.get_future().wait();
      return note("erase")(progress);
    }));
    ASSERT_OK(jobs.start_next("teach", note("teach")));
    EXPECT_FALSE(jobs.stop_and_wait("erase")) << "it has not begun";
    EXPECT_TRUE(jobs.stop_and_wait("prepare"));
    EXPECT_ERROR(jobs.start("map", note("map")), "busy (erase)");
    go.set_value();
    jobs.wait();
    EXPECT_FALSE(jobs.running());
    EXPECT_EQ(jobs.state()->kind, "teach");
    EXPECT_OK(jobs.start("map", note("map")));
    jobs.wait();
  }
  EXPECT_THAT(done, ElementsAre("erase", "teach", "map"));
  std::vector<std::string> ended;
  for (const auto& state : told.states) {
    if (state.state != "running") ended.push_back(state.kind + " " + state.state);
  }
  EXPECT_THAT(ended, ElementsAre("prepare stopped", "erase done", "teach done", "map done"));
}

TEST(Jobs, WhatHasNotBegunNeverDoesWhereAllEnds) {
  bool has_begun = false;
  {
    Jobs jobs([](const service::JobState&) {});
    ASSERT_OK(jobs.start("map", [&](Progress& progress) -> Expected<JobEnd> {
      while (!progress.interrupted()) std::this_thread::yield();
      return JobEnd{};
    }));
    ASSERT_OK(jobs.start_next("erase", [&](Progress&) -> Expected<JobEnd> {
      has_begun = true;
      return JobEnd{};
    }));
  }
  EXPECT_FALSE(has_begun);
}

TEST(Jobs, WhereNoThreadCanBeHadNoneIsRunningAndTheNextMayBegin) {
  bool has_threads = false;
  Jobs jobs(
      [](const service::JobState&) {}, [](const JobNews&) {},
      [&](std::function<void()> work) {
        if (has_threads) return std::thread(std::move(work));
        throw std::system_error(std::make_error_code(std::errc::resource_unavailable_try_again));
      });
  const auto nothing = [](Progress&) -> Expected<JobEnd> { return JobEnd{}; };
  EXPECT_ERROR(jobs.start("map", nothing), "map cannot begin: the system gives no thread");
  EXPECT_FALSE(jobs.running());
  EXPECT_FALSE(jobs.stop());
  EXPECT_FALSE(jobs.state());
  jobs.wait();
  has_threads = true;
  ASSERT_OK(jobs.start("learn", nothing));
  jobs.wait();
  EXPECT_EQ(jobs.state()->kind, "learn");
  has_threads = false;
  EXPECT_ERROR(jobs.start("map", nothing), "map cannot begin");
  EXPECT_EQ(jobs.state()->kind, "learn") << "what was done before is still told";
}

TEST(Jobs, AreStoppedWhenAskedAndWhenTheyGo) {
  Told told;
  {
    Jobs jobs(std::ref(told));
    const auto until_stopped = [](Progress& progress) -> Expected<JobEnd> {
      while (!progress.interrupted()) std::this_thread::yield();
      return Unexpected(progress.check("mapping").error());
    };
    ASSERT_OK(jobs.start("map", until_stopped));
    EXPECT_TRUE(jobs.stop());
    jobs.wait();
    EXPECT_EQ(jobs.state()->state, "stopped");
    EXPECT_EQ(jobs.state()->message, "stopped");
    EXPECT_FALSE(jobs.stop());
    ASSERT_OK(jobs.start("map", until_stopped));
  }
  EXPECT_EQ(told.states.back().state, "stopped");
}

TEST(Jobs, AFailureOfWorkThatWasToStopIsAFailure) {
  Jobs jobs([](const service::JobState&) {});
  ASSERT_OK(jobs.start("map", [](Progress& progress) -> Expected<JobEnd> {
    while (!progress.interrupted()) std::this_thread::yield();
    return fail("no disk");
  }));
  EXPECT_TRUE(jobs.stop());
  jobs.wait();
  EXPECT_EQ(jobs.state()->state, "failed");
  EXPECT_EQ(jobs.state()->text, "no disk");
}

TEST(Jobs, AFaultInTheWorkIsAFailure) {
  Jobs jobs([](const service::JobState&) {});
  ASSERT_OK(jobs.start(
      "map", [](Progress&) -> Expected<JobEnd> { throw std::runtime_error("out of range"); }));
  jobs.wait();
  EXPECT_EQ(jobs.state()->state, "failed");
  EXPECT_THAT(jobs.state()->text, HasSubstr("out of range"));
}

TEST(Jobs, AFailureIsToldWithItsReason) {
  Jobs jobs([](const service::JobState&) {});
  ASSERT_OK(jobs.start("map", [](Progress&) -> Expected<JobEnd> { return fail("no disk"); }));
  jobs.wait();
  EXPECT_EQ(jobs.state()->state, "failed");
  EXPECT_EQ(jobs.state()->text, "no disk");
  EXPECT_EQ(jobs.state()->message, "failed");
}

TEST(Jobs, AFailureThatPeopleCanMendIsToldByName) {
  Jobs jobs([](const service::JobState&) {});
  ASSERT_OK(jobs.start("learn", [](Progress&) -> Expected<JobEnd> {
    return job_failure("no_room_named", "no room is named");
  }));
  jobs.wait();
  EXPECT_EQ(jobs.state()->state, "failed");
  EXPECT_EQ(jobs.state()->message, "no_room_named");
  EXPECT_EQ(jobs.state()->text, "no room is named");
  ASSERT_OK(jobs.start("map", [](Progress&) -> Expected<JobEnd> {
    return fail_with(ErrorCode::kDiskFull, "no disk");
  }));
  jobs.wait();
  EXPECT_EQ(jobs.state()->message, "disk_full");
}

}  // namespace
}  // namespace roomwise::live
