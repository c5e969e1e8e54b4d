#pragma once

#include <atomic>
#include <condition_variable>
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
  ~Jobs();  // stops the work and waits for it

  // What is done: gets a place to tell how far it is, which also says when to stop; returns what
  // came of it.
  using Body = std::function<Expected<JobEnd>(Progress&)>;
  // Fails where a job is running already, or no thread can be had for it: then it never ran.
  [[nodiscard]] Expected<void> start(const std::string& kind, Body body);
  // Asks the running job to stop, of that kind if one is given. False where none such is running.
  bool stop(std::optional<std::string_view> kind = {});
  // Returns when no job is running.
  void wait();
  [[nodiscard]] bool running() const;
  // Of the newest job; nothing where there was none.
  [[nodiscard]] std::optional<service::JobState> state() const;

 private:
  class Teller;
  void publish(const service::JobState& state);
  void run(const std::string& kind, const Body& body);  // on its thread

  std::function<void(const service::JobState&)> tell_;
  std::function<void(const JobNews&)> report_;
  std::function<std::thread(std::function<void()>)> start_thread_;
  std::mutex thread_mutex_;  // of thread_, taken before mutex_
  mutable std::mutex mutex_;
  std::condition_variable ended_;
  std::optional<service::JobState> state_;
  bool running_ = false;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace roomwise::live
