#include "terminal_progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace roomwise::app {
namespace {

using std::chrono::duration;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr milliseconds kFirstMoment{250};
constexpr milliseconds kBetweenBars{100};
// In a log: a line every tenth of the work, but not more often than every second, and not more
// seldom than every ten.
constexpr seconds kShortestBetweenLines{1};
constexpr seconds kLongestBetweenLines{10};
constexpr int kPercentBetweenLines = 10;
constexpr int kBarWidth = 24;

TerminalProgress::Output standard_error() {
  TerminalProgress::Output output;
  output.write = [](std::string_view text) {
    std::fwrite(text.data(), 1, text.size(), stderr);
    std::fflush(stderr);
  };
  output.is_terminal = ::isatty(STDERR_FILENO) == 1;
  winsize size{};
  if (::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) {
    output.columns = size.ws_col;
  }
  return output;
}

std::string bar(int percent) {
  const auto filled = static_cast<std::size_t>(percent * kBarWidth / 100);
  return fmt::format("[{}{}]", std::string(filled, '#'), std::string(kBarWidth - filled, '.'));
}

}  // namespace

void TimeLeft::start(Time now) {
  began_ = now;
  from_ = last_ = {now, 0};
}

void TimeLeft::update(Time now, std::uint64_t done) {
  last_ = {now, done};
  if (now - began_ < kFirstMoment) from_ = last_;
}

std::optional<double> TimeLeft::seconds(std::uint64_t total) const {
  if (total <= last_.done) return 0.0;
  const double elapsed_s = duration<double>(last_.time - from_.time).count();
  if (last_.done <= from_.done || elapsed_s <= 0) return std::nullopt;
  const double per_second = static_cast<double>(last_.done - from_.done) / elapsed_s;
  return static_cast<double>(total - last_.done) / per_second;
}

std::string format_duration(double seconds) {
  const auto whole = static_cast<std::int64_t>(std::llround(std::max(0.0, seconds)));
  if (whole < 3600) return fmt::format("{}:{:02}", whole / 60, whole % 60);
  return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

TerminalProgress::TerminalProgress(Output output, Clock clock, std::function<bool()> interrupted)
    : output_(std::move(output)), clock_(std::move(clock)), interrupted_(std::move(interrupted)) {}

TerminalProgress::TerminalProgress(std::function<bool()> interrupted)
    : TerminalProgress(
          standard_error(), [] { return std::chrono::steady_clock::now(); },
          std::move(interrupted)) {}

TerminalProgress::~TerminalProgress() {
  finish_line();
}

void TerminalProgress::begin(std::string_view work, std::optional<std::uint64_t> total) {
  finish_line();
  work_ = work;
  total_ = total;
  done_ = 0;
  note_.clear();
  started_ = clock_();
  shown_ = started_;
  shown_percent_ = 0;
  time_left_.start(started_);
  if (output_.is_terminal) show_bar();
}

void TerminalProgress::advance(std::uint64_t done, std::string_view note) {
  done_ = done;
  note_ = note;
  const TimeLeft::Time now = clock_();
  time_left_.update(now, done);
  const auto since_shown = now - shown_;
  const bool all_done = total_ && done_ >= *total_;
  if (output_.is_terminal) {
    if (since_shown < kBetweenBars) return;
    show_bar();
  } else {
    const bool tenth_done = total_ && percent() - shown_percent_ >= kPercentBetweenLines;
    const auto wait = tenth_done ? kShortestBetweenLines : kLongestBetweenLines;
    if (since_shown < wait || all_done) return;  // end() says that all is done
    show_line();
  }
  shown_ = now;
  shown_percent_ = percent();
}

void TerminalProgress::end() {
  if (total_ == 0 && !line_open_) return;  // there was nothing to do
  const double elapsed_s = duration<double>(clock_() - started_).count();
  std::string line = fmt::format("{}: {} in {}", work_, done_,
                                 elapsed_s < 1 ? "under a second" : format_duration(elapsed_s));
  if (!note_.empty()) line += ", " + note_;
  // The erased rest of the line: what stood there before may have been longer.
  output_.write(line_open_ ? "\r" + line + "\x1b[K\n" : line + "\n");
  line_open_ = false;
}

bool TerminalProgress::interrupted() const {
  return interrupted_();
}

void TerminalProgress::note(std::string_view text) {
  finish_line();
  output_.write(fmt::format("note: {}\n", text));
}

void TerminalProgress::finish_line() {
  if (line_open_) output_.write("\n");
  line_open_ = false;
}

int TerminalProgress::percent() const {
  if (!total_ || *total_ == 0) return 0;
  const double part = static_cast<double>(done_) / static_cast<double>(*total_);
  return std::clamp(static_cast<int>(100 * part), 0, 100);
}

// "112/373, 0:23 left, 12 key-frames"
std::string TerminalProgress::numbers() const {
  std::string text = total_ ? fmt::format("{}/{}", done_, *total_) : fmt::format("{}", done_);
  if (total_) {
    if (const auto left_s = time_left_.seconds(*total_)) {
      text += fmt::format(", {} left", format_duration(*left_s));
    }
  }
  if (!note_.empty()) text += ", " + note_;
  return text;
}

void TerminalProgress::show_bar() {
  std::string line = work_ + " ";
  if (total_) line += fmt::format("{} {:3} % ", bar(percent()), percent());
  line += numbers();
  // A line as wide as the terminal would wrap and could not be written over.
  const auto most = static_cast<std::size_t>(std::max(output_.columns - 1, 1));
  if (line.size() > most) line.resize(most);
  output_.write("\r" + line + "\x1b[K");
  line_open_ = true;
}

void TerminalProgress::show_line() {
  if (total_) {
    output_.write(fmt::format("{}: {} %, {}\n", work_, percent(), numbers()));
  } else {
    output_.write(fmt::format("{}: {}\n", work_, numbers()));
  }
}

}  // namespace roomwise::app
