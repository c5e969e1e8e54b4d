#include "child_program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdlib>
#include <mutex>
#include <thread>
#include <utility>

namespace roomwise::bench {

// What a child wrote, filled by a thread until the child's outputs are closed.
struct ChildProgram::Lines {
  struct Line {
    double at_s = 0;
    std::string text;
  };
  mutable std::mutex mutex;
  std::condition_variable changed;
  std::vector<Line> lines;
  bool closed = false;
  int output = -1;
  std::thread reader;

  void read_all() {
    std::string line;
    for (std::array<char, 4096> bytes{};;) {
      const ssize_t count = ::read(output, bytes.data(), bytes.size());
      const std::scoped_lock lock(mutex);
      if (count <= 0) {
        if (!line.empty()) lines.push_back({now_s(), line});
        closed = true;
        changed.notify_all();
        return;
      }
      for (const char c : std::string_view(bytes.data(), static_cast<std::size_t>(count))) {
        if (c != '\n') {
          line += c;
          continue;
        }
        lines.push_back({now_s(), std::exchange(line, {})});
      }
      changed.notify_all();
    }
  }
};

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string sibling_program(const std::string& name) {
  return (std::filesystem::read_symlink("/proc/self/exe").parent_path() / name).string();
}

ChildProgram::ChildProgram(std::vector<std::string> words, std::vector<std::string> environment)
    : lines_(std::make_shared<Lines>()) {
  std::signal(SIGPIPE, SIG_IGN);  // typing into a program that has ended
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  std::vector<char*> variables;
  for (std::string& variable : environment) variables.push_back(variable.data());
  for (char** variable = environ; *variable != nullptr; ++variable) variables.push_back(*variable);
  variables.push_back(nullptr);

  std::array<int, 2> input{};
  std::array<int, 2> output{};
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  if (pipe2(input.data(), O_CLOEXEC) != 0 || pipe2(output.data(), O_CLOEXEC) != 0) std::abort();
  posix_spawn_file_actions_adddup2(&files, input[0], STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, output[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, output[1], STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t as_usual;  // and not as here
  sigemptyset(&as_usual);
  sigaddset(&as_usual, SIGPIPE);
  posix_spawnattr_setsigdefault(&attributes, &as_usual);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
  const int spawned =
      posix_spawnp(&process_, argv[0], &files, &attributes, argv.data(), variables.data());
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  ::close(input[0]);
  ::close(output[1]);
  if (spawned != 0) {
    fmt::print(stderr, "{} cannot be started\n", words.front());
    std::exit(1);
  }
  input_ = input[1];
  lines_->output = output[0];
  lines_->reader = std::thread([lines = lines_.get()] { lines->read_all(); });
}

ChildProgram::ChildProgram(ChildProgram&& other) noexcept
    : lines_(std::move(other.lines_)),
      process_(std::exchange(other.process_, -1)),
      input_(std::exchange(other.input_, -1)) {}

ChildProgram& ChildProgram::operator=(ChildProgram&& other) noexcept {
  std::swap(lines_, other.lines_);
  std::swap(process_, other.process_);
  std::swap(input_, other.input_);
  return *this;
}

ChildProgram::~ChildProgram() {
  if (!lines_) return;
  if (process_ > 0) {
    send(SIGKILL);
    wait();
  }
  ::close(input_);
  lines_->reader.join();
  ::close(lines_->output);
}

void ChildProgram::type(std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = ::write(input_, text.data(), text.size());
    if (count <= 0) return;  // it has ended, as wait() will tell
    text.remove_prefix(static_cast<std::size_t>(count));
  }
}

void ChildProgram::send(int signal) const {
  if (process_ > 0) ::kill(process_, signal);
}

int ChildProgram::wait() {
  if (process_ <= 0) return -1;  // it has ended before
  int status = 0;
  if (waitpid(std::exchange(process_, -1), &status, 0) < 0) return -1;
  std::unique_lock lock(lines_->mutex);
  lines_->changed.wait(lock, [this] { return lines_->closed; });
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

std::optional<double> ChildProgram::line_after(double since_s, std::string_view text,
                                               double until_s) const {
  std::unique_lock lock(lines_->mutex);
  for (std::size_t next = 0;;) {
    for (; next < lines_->lines.size(); ++next) {
      const Lines::Line& line = lines_->lines[next];
      if (line.at_s > since_s && line.text.find(text) != std::string::npos) return line.at_s;
    }
    if (lines_->closed || now_s() >= until_s) return std::nullopt;
    lines_->changed.wait_for(lock, std::chrono::duration<double>(until_s - now_s()));
  }
}

std::string ChildProgram::line_with(std::string_view text) const {
  const std::scoped_lock lock(lines_->mutex);
  for (const Lines::Line& line : lines_->lines) {
    if (line.text.find(text) != std::string::npos) return line.text;
  }
  return {};
}

std::size_t ChildProgram::count_after(double since_s, std::string_view text) const {
  const std::scoped_lock lock(lines_->mutex);
  std::size_t count = 0;
  for (const Lines::Line& line : lines_->lines) {
    if (line.at_s > since_s && line.text.find(text) != std::string::npos) ++count;
  }
  return count;
}

std::string ChildProgram::output() const {
  const std::scoped_lock lock(lines_->mutex);
  std::string all;
  for (const Lines::Line& line : lines_->lines) all += line.text + "\n";
  return all;
}

FinishedProgram run_to_end(std::vector<std::string> words) {
  ChildProgram program(std::move(words));
  FinishedProgram finished;
  finished.exit_code = program.wait();
  finished.output = program.output();
  return finished;
}

}  // namespace roomwise::bench
