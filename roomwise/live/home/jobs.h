#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "roomwise/base/expected.h"
#include "roomwise/base/progress.h"
#include "roomwise/service/protocol/messages.h"

namespace roomwise::live {

// That a job began ("running") or how it ended, for who keeps the computer running.
struct JobNews {
  std::string kind = {};
  std::string state = {};               // as in JobState
  std::string text = {};                // what came of it
  ErrorCode code = ErrorCode::kFailed;  // where it failed
  double seconds = 0;                   // that it took
};

// What came of work: a sentence for the log and, for pages, which of their own sentences says it
// (docs/protocol.md), with its numbers. Failures whose mend people know have one, too.
struct JobEnd {
  std::string text = {};
  std::string message = {};
  std::map<std::string, std::int64_t> values = {};
  bool has_failed = false;
};
[[nodiscard]] inline JobEnd job_failure(std::string message, std::string text) {
  return {std::move(text), std::move(message), {}, true};
}

// How far a job is. What it begins (Progress::begin) is a step of the kind of job; the steps
// together are one whole that never goes back.
class JobProgress : public Progress {
 public:
  // All steps come `of` times, and have come `done` times by now.
  virtual void begin_round(std::size_t done, std::size_t of) = 0;
};

// Long work in the background, one piece at a time, that tells how far it is and can be stopped.
class Jobs {
 public:
  // `tell` is called with every change that people should see (at most five times a second while
  // work goes on), on the job's thread or on that of start(). `report`: of each job's begin and
  // end, on the job's thread, before tell() is called. `start_thread`: for tests; may throw
  // std::system_error, as std::thread does where the system gives no more threads.
  explicit Jobs(
      std::function<void(const service::JobState&)> tell,
      std::function<void(const JobNews&)> report = [](const JobNews&) {},
      std::function<std::thread(std::function<void()>)> start_thread =
          [](std::function<void()> work) { return std::thread(std::move(work)); })
      : tell_(std::move(tell)),
        report_(std::move(report)),
        start_thread_(std::move(start_thread)) {}
  ~Jobs();  // stops the work and waits for it; what has not begun never does

  // What is done: gets a place to tell how far it is, which also says when to stop; returns what
  // came of it.
  using Body = std::function<Expected<JobEnd>(JobProgress&)>;
  // Fails where a job is running already, or no thread can be had for it: then it never ran.
  [[nodiscard]] Expected<void> start(const std::string& kind, Body body);
  // The same once nothing else runs: at once, or after what runs and waits by now. Never waits.
  [[nodiscard]] Expected<void> start_next(const std::string& kind, Body body);
  // Asks the running job to stop, of that kind if one is given. False where none such is running.
  bool stop(std::optional<std::string_view> kind = {});
  // The same, and returns when that one has ended; another that waited may run then.
  bool stop_and_wait(std::string_view kind);
  // Returns when no job is running, and none waits.
  void wait();
  [[nodiscard]] bool running() const;  // or waits
  // Of the newest job; nothing where there was none.
  [[nodiscard]] std::optional<service::JobState> state() const;

 private:
  class Teller;
  struct Job {
    std::string kind;
    Body body;
  };
  void publish(const service::JobState& state);
  // With thread_mutex_ held.
  [[nodiscard]] Expected<void> begin(Job job);
  // With mutex_ held.
  void is_begun(const std::string& kind);
  void run(Job job);  // on its thread, and then those that wait
  [[nodiscard]] std::optional<Job> carry_on(const Job& job);

  std::function<void(const service::JobState&)> tell_;
  std::function<void(const JobNews&)> report_;
  std::function<std::thread(std::function<void()>)> start_thread_;
  std::mutex thread_mutex_;  // of thread_, taken before mutex_
  mutable std::mutex mutex_;
  std::condition_variable ended_;
  std::optional<service::JobState> state_;
  bool running_ = false;
  std::uint64_t begun_ = 0;
  std::deque<Job> waiting_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace roomwise::live
