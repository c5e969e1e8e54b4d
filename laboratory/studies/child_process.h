#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/base/progress.h"

namespace roomwise::studies {

using Words = std::vector<std::string>;

// Another program, run to its end. It never outlives the thread that runs it.
struct ChildRun {
  Words words;  // the program, found by PATH where it has no '/', and what it is given
  std::filesystem::path log;  // takes the place of standard error; empty: as this process's
  // Is told the last line of the log now and then; empty: nobody.
  std::function<void(const std::string& line)> heard;
};

struct ChildEnd {
  std::string printed;  // on standard output
  int status = 0;       // as waitpid() gives it

  [[nodiscard]] bool is_good() const { return status == 0; }
};

// Where the work is interrupted the program is asked to stop, too, and ErrorCode::kInterrupted
// comes back. A program that cannot be started ends with exit code 127.
[[nodiscard]] Expected<ChildEnd> run_child(const ChildRun& run, const Interruption& interruption);

// The last line of a log that is not empty.
[[nodiscard]] std::string last_line_of(const std::filesystem::path& log);

}  // namespace roomwise::studies
