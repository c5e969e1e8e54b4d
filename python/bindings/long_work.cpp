#include "python/bindings/long_work.h"

#include <chrono>

namespace roomwise::python {

void AttendedProgress::begin(std::string_view work, std::optional<std::uint64_t> total) {
  std::unique_lock lock(mutex_);
  state_ = {std::string(work), total, 0, ""};
  hand_over(lock);
}

void AttendedProgress::advance(std::uint64_t done, std::string_view note) {
  const std::lock_guard lock(mutex_);
  state_.done = done;
  state_.note = note;
  has_news_ = true;
}

void AttendedProgress::end() {
  std::unique_lock lock(mutex_);
  hand_over(lock);
}

bool AttendedProgress::interrupted() const {
  const std::lock_guard lock(mutex_);
  return is_stopped_;
}

void AttendedProgress::hand_over(std::unique_lock<std::mutex>& lock) {
  if (!is_heard_) return;
  has_news_ = true;
  is_awaited_ = true;
  changed_.notify_all();
  changed_.wait(lock, [&] { return !is_awaited_ || is_stopped_; });
}

void AttendedProgress::finish() {
  const std::lock_guard lock(mutex_);
  is_over_ = true;
  changed_.notify_all();
}

void AttendedProgress::release() {
  const std::lock_guard lock(mutex_);
  is_awaited_ = false;
  changed_.notify_all();
}

void AttendedProgress::stop() {
  const std::lock_guard lock(mutex_);
  is_stopped_ = true;
  changed_.notify_all();
}

AttendedProgress::News AttendedProgress::wait() {
  constexpr std::chrono::milliseconds kBetweenLooks{50};
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, kBetweenLooks, [&] { return is_over_ || is_awaited_; });
  News news{has_news_ ? std::optional(state_) : std::nullopt, is_awaited_, is_over_};
  has_news_ = false;
  return news;
}

std::optional<py::error_already_set> AttendedProgress::attend(const py::object& callback) {
  std::optional<py::error_already_set> raised;
  for (;;) {
    News news;
    {
      const py::gil_scoped_release released;
      news = wait();
    }
    try {
      if (!raised && PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (!raised && news.state && !callback.is_none()) {
        callback(news.state->work, news.state->done, news.state->total, news.state->note);
        // A signal that came meanwhile counts before the work goes on.
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      }
    } catch (py::error_already_set& error) {
      raised.emplace(std::move(error));
      stop();
    } catch (const std::exception& error) {  // what cannot be told in Python
      PyErr_SetString(PyExc_RuntimeError, error.what());
      raised.emplace();
      stop();
    }
    if (news.is_over) return raised;
    if (news.is_awaited) release();
  }
}

py::object checked_callback(py::object callback) {
  if (callback.is_none() || PyCallable_Check(callback.ptr()) != 0) return callback;
  throw py::type_error("progress: expected a function of (work, done, total, note), or None; got " +
                       std::string(py::str(py::type::of(callback).attr("__name__"))));
}

}  // namespace roomwise::python
