#include "roomwise/live/home/jobs.h"

#include <algorithm>
#include <chrono>
#include <system_error>
#include <vector>

#include "roomwise/base/stopwatch.h"

namespace roomwise::live {
namespace {

using Clock = std::chrono::steady_clock;
constexpr auto kBetweenNews = std::chrono::milliseconds(200);

// A fault in the work must not end the program.
Expected<JobEnd> carry_out(const Jobs::Body& body, JobProgress& progress) {
  try {
    return body(progress);
  } catch (const std::exception& fault) {
    return fail("internal error, please report it: {}", fault.what());
  }
}

// What pages say of an error of which nothing else is known.
std::string message_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInterrupted:
      return "stopped";
    case ErrorCode::kDiskFull:
      return "disk_full";
    case ErrorCode::kDamaged:
      return "damaged";
    case ErrorCode::kFailed:
    case ErrorCode::kRefused:
      break;
  }
  return "failed";
}

// The works that make up one step, and count alike.
using Works = std::vector<std::string_view>;

// The steps of a kind of job, in order, each of which counts alike: how long they take differs from
// computer to computer.
const std::vector<Works>& steps_of(std::string_view kind) {
  static const Works space = {"fusing the map", "fusing depth between pictures"};
  static const Works own_things = {"looking at what is usual", "comparing with what was taught",
                                   "looking for what was taught"};
  static const std::map<std::string_view, std::vector<Works>> steps = {
      {"map",
       {{"unpacking", "loading the map"},
        {"mapping"},
        {"looking at key-frames"},
        {"checking the camera", "adjusting landmarks"},
        {"finding features again"},
        space,
        own_things}},
      {"prepare", {{"finding features again"}, space, own_things}},
      {"learn", {{"looking at pictures"}}},
      {"teach", {own_things}}};
  static const std::vector<Works> none;
  const auto found = steps.find(kind);
  return found == steps.end() ? none : found->second;
}

// Where a work stands among the steps, and how much of them it is.
struct Share {
  double from = 0;
  double size = 0;
};
std::optional<Share> share_of(std::string_view kind, std::string_view work) {
  const auto& steps = steps_of(kind);
  for (std::size_t s = 0; s < steps.size(); ++s) {
    const auto found = std::ranges::find(steps[s], work);
    if (found == steps[s].end()) continue;
    const double size = 1.0 / static_cast<double>(steps.size() * steps[s].size());
    const auto in_step = static_cast<double>(found - steps[s].begin());
    return Share{static_cast<double>(s) / static_cast<double>(steps.size()) + in_step * size, size};
  }
  return std::nullopt;
}

}  // namespace

// Turns what the work says into states. Called on the threads of the work.
class Jobs::Teller final : public JobProgress {
 public:
  Teller(Jobs& jobs, service::JobState state) : jobs_(jobs), state_(std::move(state)) {}

  void begin(std::string_view work, std::optional<std::uint64_t> total) override {
    const std::scoped_lock lock(mutex_);
    state_.stage = work;
    state_.left_s.reset();
    share_ = share_of(state_.kind, work);
    total_ = total;
    reach(0);
    began_ = Clock::now();
    tell_now();
  }
  void advance(std::uint64_t done, std::string_view note) override {
    const std::scoped_lock lock(mutex_);
    state_.text = note;
    if (total_ && *total_ > 0) {
      const double part = std::min(1.0, static_cast<double>(done) / static_cast<double>(*total_));
      if (part > 0) state_.left_s = seconds_since(began_) * (1 - part) / part;
      reach(part);
    }
    if (Clock::now() - told_ >= kBetweenNews) tell_now();
  }
  void end() override {}
  void begin_round(std::size_t done, std::size_t of) override {
    const std::scoped_lock lock(mutex_);
    rounds_done_ = static_cast<double>(done);
    rounds_ = static_cast<double>(of);
  }
  [[nodiscard]] bool interrupted() const override { return jobs_.stop_; }

 private:
  // What is no step, or comes once more, leaves the whole where it is.
  void reach(double part) {
    if (!share_) return;
    const double whole = (rounds_done_ + share_->from + part * share_->size) / rounds_;
    state_.fraction = std::max(state_.fraction, whole);
  }
  void tell_now() {
    told_ = Clock::now();
    jobs_.publish(state_);
  }

  Jobs& jobs_;
  std::mutex mutex_;
  service::JobState state_;
  std::optional<std::uint64_t> total_;
  std::optional<Share> share_;
  double rounds_done_ = 0;
  double rounds_ = 1;
  Clock::time_point began_ = Clock::now();
  Clock::time_point told_;
};

Jobs::~Jobs() {
  {
    const std::scoped_lock lock(mutex_);
    waiting_.clear();
  }
  stop();
  if (thread_.joinable()) thread_.join();
}

void Jobs::publish(const service::JobState& state) {
  {
    const std::scoped_lock lock(mutex_);
    state_ = state;
  }
  tell_(state);
}

Expected<void> Jobs::start(const std::string& kind, Body body) {
  const std::scoped_lock starting(thread_mutex_);  // a job may end before its thread is kept
  {
    const std::scoped_lock lock(mutex_);
    if (running_) {
      return fail("the computer is busy ({}); wait until it is done, or stop it", state_->kind);
    }
  }
  return begin({kind, std::move(body)});
}

Expected<void> Jobs::start_next(const std::string& kind, Body body) {
  const std::scoped_lock starting(thread_mutex_);
  {
    const std::scoped_lock lock(mutex_);
    if (running_) {
      waiting_.push_back({kind, std::move(body)});
      return {};
    }
  }
  return begin({kind, std::move(body)});
}

Expected<void> Jobs::begin(Job job) {
  if (thread_.joinable()) thread_.join();
  const std::scoped_lock lock(mutex_);  // its thread says that it runs once it is known to
  try {
    thread_ = start_thread_([this, job] { run(job); });
  } catch (const std::system_error& fault) {
    return fail("{} cannot begin: the system gives no thread for it ({}); close other programs",
                job.kind, fault.what());
  }
  running_ = true;
  is_begun(job.kind);
  return {};
}

void Jobs::is_begun(const std::string& kind) {
  ++begun_;
  stop_ = false;
  state_ = service::JobState{kind, "running", "", 0, {}, ""};
}

void Jobs::run(Job job) {
  while (auto next = carry_on(job)) job = *std::move(next);
}

// Returns what waits.
std::optional<Jobs::Job> Jobs::carry_on(const Job& job) {
  service::JobState state{job.kind, "running", "", 0, {}, ""};
  const Clock::time_point began = Clock::now();
  report_({.kind = job.kind, .state = state.state});
  publish(state);
  Teller teller(*this, state);
  const Expected<JobEnd> end = carry_out(job.body, teller);
  const ErrorCode code = end ? ErrorCode::kFailed : end.error().code;
  const bool is_done = end && !end->has_failed;
  state.fraction = is_done ? 1 : 0;
  state.state = is_done ? "done" : code == ErrorCode::kInterrupted ? "stopped" : "failed";
  state.text = end ? end->text : end.error().message;
  state.message = end ? end->message : message_of(code);
  if (end) state.values = end->values;
  report_({job.kind, state.state, state.text, code, seconds_since(began)});
  std::optional<Job> next;
  {
    const std::scoped_lock lock(mutex_);
    state_ = state;
    running_ = !waiting_.empty();
    if (running_) {
      next = std::move(waiting_.front());
      waiting_.pop_front();
      is_begun(next->kind);
    }
  }
  tell_(state);
  ended_.notify_all();
  return next;
}

bool Jobs::stop(std::optional<std::string_view> kind) {
  const std::scoped_lock lock(mutex_);
  if (!running_ || (kind && state_->kind != *kind)) return false;
  stop_ = true;
  return true;
}

bool Jobs::stop_and_wait(std::string_view kind) {
  std::unique_lock lock(mutex_);
  if (!running_ || state_->kind != kind) return false;
  stop_ = true;
  ended_.wait(lock, [this, this_one = begun_] { return !running_ || begun_ != this_one; });
  return true;
}

void Jobs::wait() {
  std::unique_lock lock(mutex_);
  ended_.wait(lock, [this] { return !running_; });
}

bool Jobs::running() const {
  const std::scoped_lock lock(mutex_);
  return running_;
}

std::optional<service::JobState> Jobs::state() const {
  const std::scoped_lock lock(mutex_);
  return state_;
}

}  // namespace roomwise::live
