#pragma once

#include <sys/types.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace roomwise::bench {

// The program of this name in the folder in which this program lies.
[[nodiscard]] std::string sibling_program(const std::string& name);

// A program that runs beside this one: what it writes is kept line by line with the time at which
// it came, and it can be typed into. Ends this program where it cannot be started; it is killed
// where it still runs at the end.
class ChildProgram {
 public:
  // `words`: the program, looked for in PATH, and its arguments. `environment`: NAME=VALUE, added
  // to this program's.
  explicit ChildProgram(std::vector<std::string> words, std::vector<std::string> environment = {});
  ~ChildProgram();
  ChildProgram(ChildProgram&&) noexcept;
  ChildProgram& operator=(ChildProgram&&) noexcept;

  void type(std::string_view text);
  void send(int signal) const;
  // Its end, and that of its outputs: the exit code, or 128 and the signal that ended it.
  int wait();

  // When the first line that holds `text` came, out of those that came after `since_s`; waits for
  // it until `until_s`. Seconds as now_s() counts them; both of its outputs count.
  [[nodiscard]] std::optional<double> line_after(double since_s, std::string_view text,
                                                 double until_s) const;
  // Of all lines so far, the first that holds `text`; empty: none does.
  [[nodiscard]] std::string line_with(std::string_view text) const;
  [[nodiscard]] std::size_t count_after(double since_s, std::string_view text) const;
  [[nodiscard]] std::string output() const;

 private:
  struct Lines;
  std::shared_ptr<Lines> lines_;
  pid_t process_ = -1;
  int input_ = -1;
};

// Runs a program to its end; what it wrote. `exit_code`: as ChildProgram::wait().
struct FinishedProgram {
  int exit_code = 0;
  std::string output;
};
[[nodiscard]] FinishedProgram run_to_end(std::vector<std::string> words);

// Seconds on the steady clock.
[[nodiscard]] double now_s();

}  // namespace roomwise::bench
