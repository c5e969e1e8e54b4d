#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "roomwise/base/progress.h"

namespace roomwise::app {

// How long work will still take, by its speed over all that was done of it so far: parts are of
// unequal length, and the speed of the last few would jump. What is told done within the first
// moment was done before (work that goes on), and says nothing of the speed.
class TimeLeft {
 public:
  using Time = std::chrono::steady_clock::time_point;

  void start(Time now);
  void update(Time now, std::uint64_t done);
  // Seconds until `total` units are done; nothing before there is a speed to go by.
  [[nodiscard]] std::optional<double> seconds(std::uint64_t total) const;

 private:
  struct Sample {
    Time time;
    std::uint64_t done = 0;
  };
  Time began_;
  Sample from_, last_;
};

// "0:07", "12:30", "1:02:03".
[[nodiscard]] std::string format_duration(double seconds);

// Shows the progress of long work: on a terminal one line that is written over, with a bar and the
// time left; elsewhere (a log) a plain line now and then. Writes to standard error only, so that
// standard output stays clean for results.
class TerminalProgress final : public Progress {
 public:
  struct Output {
    std::function<void(std::string_view)> write;
    bool is_terminal = false;
    int columns = 80;  // of the terminal
  };
  using Clock = std::function<TimeLeft::Time()>;

  // interrupted: whether the user asked to stop.
  TerminalProgress(Output output, Clock clock, std::function<bool()> interrupted);
  // On standard error with the steady clock.
  explicit TerminalProgress(std::function<bool()> interrupted);
  // Work that failed midway leaves its line; what is printed next starts on a new one.
  ~TerminalProgress() override;
  TerminalProgress(const TerminalProgress&) = delete;
  TerminalProgress& operator=(const TerminalProgress&) = delete;

  void begin(std::string_view work, std::optional<std::uint64_t> total) override;
  void advance(std::uint64_t done, std::string_view note) override;
  void end() override;
  [[nodiscard]] bool interrupted() const override;

  // A line of its own that the user should read.
  void note(std::string_view text);

  // Leaves the line that is being written over, if there is one.
  void finish_line();

 private:
  void show_bar();
  void show_line();
  [[nodiscard]] std::string numbers() const;
  [[nodiscard]] int percent() const;

  Output output_;
  Clock clock_;
  std::function<bool()> interrupted_;

  std::string work_;
  std::optional<std::uint64_t> total_;
  std::uint64_t done_ = 0;
  std::string note_;
  TimeLeft time_left_;
  TimeLeft::Time started_;
  TimeLeft::Time shown_;    // when the last line was written
  int shown_percent_ = 0;   // what it said
  bool line_open_ = false;  // on a terminal: the cursor stands in the progress line
};

}  // namespace roomwise::app
