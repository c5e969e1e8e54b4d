#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "laboratory/studies/child_process.h"
#include "roomwise/base/expected.h"
#include "roomwise/base/progress.h"

// Studies are made of runs of the program `roomwise`, each a process of its own, so that its
// processor time is its own and a crash costs one run. What a run printed is kept, so a study that
// was killed goes on from there.
namespace roomwise::studies {

struct ProgramRun {
  Words words;                // what is asked; with other words it is another result
  Words more;                 // what changes no result: --threads
  std::filesystem::path log;  // for what it says while it works; empty: standard error
  // Is told the last line of the log now and then; empty: nobody.
  std::function<void(const std::string& line)> heard;
  std::string program = "roomwise";  // or another that lies beside this one
  std::string made_with = {};        // what else decides the result: the program's version
};

// Runs the program to its end and gives its standard output. Fails, with the program's own reason
// where there is a log, if it did not end well.
using RunProgram = std::function<Expected<std::string>(const ProgramRun&)>;

// The program beside this one. Where the work is interrupted it is asked to stop, too;
// it never outlives this process.
[[nodiscard]] RunProgram roomwise_beside(const Interruption& interruption);

// What the run printed, where `file` keeps it. Fails where the file keeps something else, such as
// the result of other words or of what was made with something else.
[[nodiscard]] Expected<std::optional<nlohmann::json>> kept_result(
    const ProgramRun& run, const std::filesystem::path& file);

// What the run prints with --json, kept in `file`, which is there only when all is done; with the
// words as "command", and with "made_with" where that says something. A run that is kept is not run
// again.
[[nodiscard]] Expected<nlohmann::json> run_kept(const ProgramRun& run,
                                                const std::filesystem::path& file,
                                                const RunProgram& program);

}  // namespace roomwise::studies
