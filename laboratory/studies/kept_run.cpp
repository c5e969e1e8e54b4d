#include "laboratory/studies/kept_run.h"

#include <fmt/ranges.h>
#include <sys/wait.h>

#include "roomwise/base/file.h"

namespace roomwise::studies {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string command_of(const Words& words) {
  return fmt::format("{}", fmt::join(words, " "));
}

// The last line of the log says why a program failed.
std::string reason_in(const fs::path& log) {
  std::string reason = last_line_of(log);
  for (const std::string_view prefix : {"roomwise: ", "roomwise-lab: "}) {
    if (reason.starts_with(prefix)) reason.erase(0, prefix.size());
  }
  return reason;
}

Error error_of(const ProgramRun& run, int status) {
  const std::string reason = reason_in(run.log);
  const std::string& name = run.words.front();
  if (WIFSIGNALED(status)) {
    return {fmt::format("{} {} was ended by signal {}", run.program, name, WTERMSIG(status))};
  }
  if (reason.empty()) return {fmt::format("{} {} failed", run.program, name)};
  return {fmt::format("{} {}: {}", run.program, name, reason)};
}

}  // namespace

RunProgram roomwise_beside(const Interruption& interruption) {
  return [&interruption](const ProgramRun& run) -> Expected<std::string> {
    std::error_code unknown;
    const fs::path program =
        fs::read_symlink("/proc/self/exe", unknown).parent_path() / run.program;
    if (unknown || !fs::exists(program)) {
      return fail(
          "{}: is not there; it is the program that does the work, build it beside this one",
          program.string());
    }
    Words words{program.string()};
    words.insert(words.end(), run.words.begin(), run.words.end());
    words.insert(words.end(), run.more.begin(), run.more.end());
    words.emplace_back("--json");
    ROOMWISE_TRY(ChildEnd end, run_child({std::move(words), run.log, run.heard}, interruption));
    if (!end.is_good()) return Unexpected(error_of(run, end.status));
    return std::move(end.printed);
  };
}

Expected<std::optional<json>> kept_result(const ProgramRun& run, const fs::path& file) {
  if (!fs::exists(file)) return std::optional<json>();
  ROOMWISE_TRY(const std::string text, read_text_file(file));
  json made = json::parse(text, nullptr, false);
  const auto text_in = [&](const char* key) {
    return made.is_object() ? made.value(key, std::string()) : std::string();
  };
  if (text_in("command") != command_of(run.words)) {
    return fail("{} was made by another command, '{}'; remove it to have it made anew",
                file.string(), text_in("command"));
  }
  if (text_in("made_with") == run.made_with) return std::optional(std::move(made));
  return fail("{} was made with '{}', not with '{}'; remove it to have it made anew", file.string(),
              text_in("made_with"), run.made_with);
}

Expected<json> run_kept(const ProgramRun& run, const fs::path& file, const RunProgram& program) {
  ROOMWISE_TRY(auto kept, kept_result(run, file));
  if (kept) return std::move(*kept);
  ROOMWISE_TRY(const std::string printed, program(run));
  json made = json::parse(printed, nullptr, false);
  if (!made.is_object()) return fail("{} {} printed no JSON", run.program, run.words.front());
  made["command"] = command_of(run.words);
  if (!run.made_with.empty()) made["made_with"] = run.made_with;
  ROOMWISE_RETURN_IF_ERROR(write_file(file, made.dump()));
  return made;
}

}  // namespace roomwise::studies
