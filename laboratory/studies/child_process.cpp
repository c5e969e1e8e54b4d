#include "laboratory/studies/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>

#include "roomwise/base/file.h"

namespace roomwise::studies {

namespace fs = std::filesystem;

std::string last_line_of(const fs::path& log) {
  if (log.empty()) return "";
  const auto text = read_text_file(log);
  if (!text) return "";
  const std::size_t end = text->find_last_not_of("\r\n ");
  if (end == std::string::npos) return "";
  const std::size_t before = text->find_last_of("\r\n", end);
  const std::size_t begin = before == std::string::npos ? 0 : before + 1;
  return text->substr(begin, end + 1 - begin);
}

namespace {

// What becomes of the child between fork and exec: only calls that are safe there.
[[noreturn]] void become(std::vector<char*>& arguments, int output, const char* log) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  dup2(output, STDOUT_FILENO);
  if (*log != '\0') {
    const int file = open(log, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (file >= 0) dup2(file, STDERR_FILENO);
  }
  execvp(arguments.front(), arguments.data());
  constexpr int kNotFound = 127;  // as shells say it
  _exit(kNotFound);
}

// All that the child writes until it closes its output. Asks it to stop, once, where the work is
// interrupted.
std::string read_while_it_runs(int output, pid_t process, const ChildRun& run,
                               const Interruption& interruption) {
  constexpr int kLookEvery_ms = 200;
  std::string text;
  std::string heard;
  bool was_asked = false;
  for (std::array<char, 4096> bytes{};;) {
    if (!was_asked && interruption.interrupted()) {
      kill(process, SIGTERM);
      was_asked = true;
    }
    pollfd ready{output, POLLIN, 0};
    if (poll(&ready, 1, kLookEvery_ms) <= 0) {
      if (!run.heard) continue;
      std::string line = last_line_of(run.log);
      if (line != heard) run.heard(heard = std::move(line));
      continue;
    }
    const ssize_t count = read(output, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return text;
    text.append(bytes.data(), static_cast<std::size_t>(count));
  }
}

}  // namespace

Expected<ChildEnd> run_child(const ChildRun& run, const Interruption& interruption) {
  Words words = run.words;
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const std::string log = run.log.string();
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) {
    return fail("{}: cannot be started: {}", words.front(), std::strerror(errno));
  }
  const pid_t process = fork();
  if (process == 0) become(arguments, ends[1], log.c_str());
  close(ends[1]);
  if (process < 0) {
    close(ends[0]);
    return fail("{}: cannot be started: {}", words.front(), std::strerror(errno));
  }
  ChildEnd end;
  end.printed = read_while_it_runs(ends[0], process, run, interruption);
  close(ends[0]);
  while (waitpid(process, &end.status, 0) < 0 && errno == EINTR) continue;
  ROOMWISE_RETURN_IF_ERROR(interruption.check("running " + words.front()));
  return end;
}

}  // namespace roomwise::studies
