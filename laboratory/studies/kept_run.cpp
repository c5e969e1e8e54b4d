#include "laboratory/studies/kept_run.h"

#include <fcntl.h>
#include <fmt/ranges.h>
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
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string command_of(const Words& words) {
  return fmt::format("{}", fmt::join(words, " "));
}

// What becomes of the child between fork and exec: only calls that are safe there.
[[noreturn]] void become(std::vector<char*>& arguments, int output, const char* log) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  dup2(output, STDOUT_FILENO);
  if (*log != '\0') {
    const int file = open(log, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (file >= 0) dup2(file, STDERR_FILENO);
  }
  execv(arguments.front(), arguments.data());
  constexpr int kNotFound = 127;  // as shells say it
  _exit(kNotFound);
}

std::string last_line(const fs::path& log) {
  if (log.empty()) return "";
  const auto text = read_text_file(log);
  if (!text) return "";
  const std::size_t end = text->find_last_not_of("\r\n ");
  if (end == std::string::npos) return "";
  const std::size_t before = text->find_last_of("\r\n", end);
  const std::size_t begin = before == std::string::npos ? 0 : before + 1;
  return text->substr(begin, end + 1 - begin);
}

// All that the child writes until it closes its output. Asks it to stop, once, where the work is
// interrupted.
std::string read_while_it_runs(int output, pid_t process, const ProgramRun& run,
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
      std::string line = last_line(run.log);
      if (line != heard) run.heard(heard = std::move(line));
      continue;
    }
    const ssize_t count = read(output, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return text;
    text.append(bytes.data(), static_cast<std::size_t>(count));
  }
}

// The last line of the log says why a program failed.
std::string reason_in(const fs::path& log) {
  std::string reason = last_line(log);
  constexpr std::string_view kPrefix = "roomwise: ";
  if (reason.starts_with(kPrefix)) reason.erase(0, kPrefix.size());
  return reason;
}

Error error_of(const ProgramRun& run, int status) {
  const std::string reason = reason_in(run.log);
  const std::string& name = run.words.front();
  if (WIFSIGNALED(status)) {
    return {fmt::format("roomwise {} was ended by signal {}", name, WTERMSIG(status))};
  }
  if (reason.empty()) return {fmt::format("roomwise {} failed", name)};
  return {fmt::format("roomwise {}: {}", name, reason)};
}

}  // namespace

RunProgram roomwise_beside(const Interruption& interruption) {
  return [&interruption](const ProgramRun& run) -> Expected<std::string> {
    std::error_code unknown;
    const fs::path program = fs::read_symlink("/proc/self/exe", unknown).parent_path() / "roomwise";
    if (unknown || !fs::exists(program)) {
      return fail(
          "{}: is not there; it is the program that does the work, build it beside this one",
          program.string());
    }
    Words words{program.string()};
    words.insert(words.end(), run.words.begin(), run.words.end());
    words.insert(words.end(), run.more.begin(), run.more.end());
    words.emplace_back("--json");
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const std::string log = run.log.string();
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) {
      return fail("{}: cannot be started: {}", program.string(), std::strerror(errno));
    }
    const pid_t process = fork();
    if (process == 0) become(arguments, ends[1], log.c_str());
    close(ends[1]);
    if (process < 0) {
      close(ends[0]);
      return fail("{}: cannot be started: {}", program.string(), std::strerror(errno));
    }
    std::string printed = read_while_it_runs(ends[0], process, run, interruption);
    close(ends[0]);
    int status = 0;
    while (waitpid(process, &status, 0) < 0 && errno == EINTR) continue;
    ROOMWISE_CHECK_OK(interruption.check("running roomwise " + run.words.front()));
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return Unexpected(error_of(run, status));
    return printed;
  };
}

Expected<std::optional<json>> kept_result(const Words& words, const fs::path& file) {
  if (!fs::exists(file)) return std::optional<json>();
  ROOMWISE_TRY(const std::string text, read_text_file(file));
  json made = json::parse(text, nullptr, false);
  const std::string by = made.is_object() ? made.value("command", "") : "";
  if (by == command_of(words)) return std::optional(std::move(made));
  return fail("{} was made by another command, '{}'; remove it to have it made anew", file.string(),
              by);
}

Expected<json> run_kept(const ProgramRun& run, const fs::path& file, const RunProgram& program) {
  ROOMWISE_TRY(auto kept, kept_result(run.words, file));
  if (kept) return std::move(*kept);
  ROOMWISE_TRY(const std::string printed, program(run));
  json made = json::parse(printed, nullptr, false);
  if (!made.is_object()) return fail("roomwise {} printed no JSON", run.words.front());
  made["command"] = command_of(run.words);
  ROOMWISE_CHECK_OK(write_file(file, made.dump()));
  return made;
}

}  // namespace roomwise::studies
