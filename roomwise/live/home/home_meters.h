#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

#include "roomwise/live/home/jobs.h"
#include "roomwise/service/protocol/messages.h"
#include "roomwise/service/server/metrics_text.h"

namespace roomwise::live {

// What happened in a home since it was opened, counted and told in its log, for who keeps it
// running. Never what was asked or answered. Thread-safe.
class HomeMeters {
 public:
  // `log` is told a line of each job, of what failed, and of a disk that gets full; on any thread.
  explicit HomeMeters(std::function<void(std::string_view)> log) : log_(std::move(log)) {}

  // From a question's coming to its answer's going. Questions for a way are counted as one kind,
  // whether somebody is led or only told: that somebody is led is theirs to show.
  void answered(service::Question question, double seconds);
  // A device's frame was looked at, or could not be.
  void looked(double seconds, bool well);
  void on_job(const JobNews& news);
  // Something other than a job could not be done: "a recording", "a change", "a picture".
  void failed(std::string_view what, const Error& error);
  // How much of the disk is free. Told in the log when little is left, and when there is more
  // again.
  void disk(std::uint64_t free_bytes);

  // How many of the loaded networks are not those that the home was made with.
  void networks_changed(std::size_t count);

  void write(service::MetricsText& text) const;

 private:
  void count_failure(std::string_view what, ErrorCode code);

  std::function<void(std::string_view)> log_;
  mutable std::mutex mutex_;
  std::map<std::string_view, service::LatencyHistogram> answers_;  // by kind of question
  service::LatencyHistogram frames_{service::kWaitingBounds_s};
  std::uint64_t frames_failed_ = 0;
  std::map<std::string, service::LatencyHistogram> jobs_;                  // ended, by kind
  std::map<std::pair<std::string, std::string>, std::uint64_t> job_ends_;  // kind, state
  std::map<std::pair<std::string, std::string>, std::uint64_t> failures_;  // what, why
  std::string running_;                                                    // job
  std::uint64_t disk_free_bytes_ = 0;
  bool disk_is_low_ = false;
  std::size_t networks_changed_ = 0;
};

}  // namespace roomwise::live
