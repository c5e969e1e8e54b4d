#include "roomwise/live/home/home_meters.h"

namespace roomwise::live {
namespace {

// Recording stops being safe: a minute of whole frames takes about half of it. As for uploads.
constexpr std::uint64_t kLittle_bytes = std::uint64_t{1} << 30U;

std::string_view why(ErrorCode code) {
  switch (code) {
    case ErrorCode::kDiskFull:
      return "disk_full";
    case ErrorCode::kDamaged:
      return "damaged";
    case ErrorCode::kInterrupted:
    case ErrorCode::kRefused:
    case ErrorCode::kFailed:
      break;
  }
  return "other";
}

std::string_view kind_of(service::Question question) {
  switch (question) {
    case service::Question::kWayTo:
    case service::Question::kTakeMeTo:
    case service::Question::kTakeMeBack:
    case service::Question::kGuide:
      return "way";
    default:
      return service::to_string(question);
  }
}

}  // namespace

void HomeMeters::answered(service::Question question, double seconds) {
  const std::scoped_lock lock(mutex_);
  answers_.try_emplace(kind_of(question), service::kWaitingBounds_s).first->second.add(seconds);
}

void HomeMeters::looked(double seconds, bool well) {
  const std::scoped_lock lock(mutex_);
  frames_.add(seconds);
  if (!well) ++frames_failed_;
}

void HomeMeters::on_job(const JobNews& news) {
  const bool runs = news.state == "running";
  {
    const std::scoped_lock lock(mutex_);
    running_ = runs ? news.kind : "";
    if (!runs) {
      ++job_ends_[{news.kind, news.state}];
      jobs_.try_emplace(news.kind, service::kWorkBounds_s).first->second.add(news.seconds);
      if (news.state == "failed") count_failure("a job", news.code);
    }
  }
  log_(runs ? fmt::format("job {}: begun", news.kind)
            : fmt::format("job {}: {} after {:.1f} s: {}", news.kind, news.state, news.seconds,
                          news.text));
}

void HomeMeters::failed(std::string_view what, const Error& error) {
  {
    const std::scoped_lock lock(mutex_);
    count_failure(what, error.code);
  }
  log_(fmt::format("{} failed: {}", what, error.message));
}

void HomeMeters::count_failure(std::string_view what, ErrorCode code) {
  ++failures_[{std::string(what), std::string(why(code))}];
}

void HomeMeters::disk(std::uint64_t free_bytes) {
  bool changed = false;
  {
    const std::scoped_lock lock(mutex_);
    disk_free_bytes_ = free_bytes;
    changed =
        std::exchange(disk_is_low_, free_bytes < kLittle_bytes) != (free_bytes < kLittle_bytes);
  }
  if (!changed) return;
  const double megabytes = static_cast<double>(free_bytes) / 1e6;
  log_(free_bytes < kLittle_bytes
           ? fmt::format("the disk is nearly full: {:.0f} MB are left; free some space", megabytes)
           : fmt::format("the disk has space again: {:.0f} MB", megabytes));
}

void HomeMeters::networks_changed(std::size_t count) {
  const std::scoped_lock lock(mutex_);
  networks_changed_ = count;
}

void HomeMeters::write(service::MetricsText& text) const {
  const std::scoped_lock lock(mutex_);
  text.family("question_seconds", "histogram", "From a question's coming to its answer's going.");
  for (const auto& [kind, times] : answers_) text.histogram({{"question", kind}}, times);
  text.family("frame_seconds", "histogram", "Looking at a frame that a device sent.");
  text.histogram({}, frames_);
  text.single("frames_failed_total", "counter", "Frames that could not be looked at.",
              frames_failed_);
  text.family("job_running", "gauge", "Whether a job runs now, by its kind.");
  for (const auto& [kind, times] : jobs_) {
    if (kind != running_) text.sample({{"job", kind}}, std::uint64_t{0});
  }
  if (!running_.empty()) text.sample({{"job", running_}}, std::uint64_t{1});
  text.family("jobs_total", "counter", "Jobs that ended, by what came of them.");
  for (const auto& [end, count] : job_ends_) {
    text.sample({{"job", end.first}, {"state", end.second}}, count);
  }
  text.family("job_seconds", "histogram", "How long jobs took, however they ended.");
  for (const auto& [kind, times] : jobs_) text.histogram({{"job", kind}}, times);
  text.family("failures_total", "counter",
              "What could not be done, and whether a full disk or damage was why.");
  for (const auto& [failure, count] : failures_) {
    text.sample({{"what", failure.first}, {"why", failure.second}}, count);
  }
  text.single("disk_free_bytes", "gauge", "Free space where the home lies.", disk_free_bytes_);
  text.single("networks_changed", "gauge",
              "Networks whose files are not those that the home was made with.",
              std::uint64_t{networks_changed_});
}

}  // namespace roomwise::live
