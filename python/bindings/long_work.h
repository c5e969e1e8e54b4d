#pragma once

#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "python/bindings/outcome.h"
#include "roomwise/base/progress.h"

namespace roomwise::python {

// The progress of work that runs on a thread of its own while Python's thread waits for it
// (attend()). Python is told on its own thread: of the beginning and the end of each piece of work
// always, for which the work waits, and in between of the newest state.
class AttendedProgress final : public Progress {
 public:
  struct State {
    std::string work;
    std::optional<std::uint64_t> total;
    std::uint64_t done = 0;
    std::string note;
  };

  // `is_heard`: whether anybody wants to be told; else the work waits for nobody.
  explicit AttendedProgress(bool is_heard) : is_heard_(is_heard) {}

  void begin(std::string_view work, std::optional<std::uint64_t> total) override;
  void advance(std::uint64_t done, std::string_view note) override;
  void end() override;
  [[nodiscard]] bool interrupted() const override;

  // The work is over: attend() returns.
  void finish();
  // Waits without the GIL until the work is over. Meanwhile it asks Python for signals, and calls
  // callback(work, done, total, note) unless it is None; what either raises stops the work and is
  // returned. The GIL must be held.
  [[nodiscard]] std::optional<py::error_already_set> attend(const py::object& callback);

 private:
  struct News {
    std::optional<State> state;
    bool is_awaited = false;
    bool is_over = false;
  };
  void hand_over(std::unique_lock<std::mutex>& lock);
  [[nodiscard]] News wait();
  void release();
  void stop();

  const bool is_heard_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  State state_;
  bool has_news_ = false;
  bool is_awaited_ = false;  // the work waits until the news are taken
  bool is_over_ = false;
  bool is_stopped_ = false;
};

// A callback that may be given: None or what can be called.
[[nodiscard]] py::object checked_callback(py::object callback);

// What work(progress) gives, an Expected<T>: it runs without the GIL on a thread of its own, and
// must not touch Python. Ctrl-C interrupts it; KeyboardInterrupt, or what the callback raised, is
// raised when it has stopped, with what it keeps for such a case kept.
template <typename Work>
auto run_long(const py::object& callback, const Work& work) {
  using Outcome = decltype(work(std::declval<Progress&>()));
  const py::object heard = checked_callback(callback);
  AttendedProgress progress(!heard.is_none());
  std::optional<Outcome> outcome;
  std::exception_ptr failure;
  std::thread worker([&] {
    try {
      outcome.emplace(work(progress));
    } catch (...) {
      failure = std::current_exception();
    }
    progress.finish();
  });
  std::optional<py::error_already_set> raised = progress.attend(heard);
  worker.join();
  if (raised) throw py::error_already_set(*std::move(raised));
  if (failure) std::rethrow_exception(failure);
  return value_of(*std::move(outcome));
}
template <typename Work>
auto run_long(const Work& work) {
  return run_long(py::none(), work);
}

}  // namespace roomwise::python
