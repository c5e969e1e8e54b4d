#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace roomwise::testing {

struct ProgramResult {
  int exit_code = -1;  // 128 + the signal's number where a signal ended it
  std::string output;  // standard output
  std::string errors;  // standard error
};

// Runs build/.../bin/roomwise with these arguments and waits for its end. Its standard input is
// empty, and ROOMWISE_MODELS names a folder without networks; so does XDG_DATA_HOME unless
// data_folder is given.
ProgramResult run_roomwise(const std::vector<std::string>& arguments,
                           const std::string& data_folder = {});

// The same with another program.
ProgramResult run_program(const std::string& program, const std::vector<std::string>& arguments,
                          const std::string& data_folder = {});

// A program that runs beside the test. It is killed where it still runs at the end.
class RunningProgram {
 public:
  RunningProgram(int process, int output, std::string errors_file)
      : process_(process), output_(output), errors_file_(std::move(errors_file)) {}
  ~RunningProgram();
  RunningProgram(RunningProgram&& other) noexcept
      : process_(std::exchange(other.process_, -1)),
        output_(std::exchange(other.output_, -1)),
        errors_file_(std::exchange(other.errors_file_, {})) {}
  RunningProgram& operator=(RunningProgram&&) = delete;

  // The next line of its standard output, without its end; false where there is no more.
  bool read_line(std::string& line);
  // Sends it the signal and waits for its end; the exit code, 128 + the number of the signal that
  // ended it.
  int end(int signal);
  // What it wrote to standard error so far.
  [[nodiscard]] std::string errors() const;

 private:
  int process_;
  int output_;
  std::string errors_file_;
};

// The same program as run_roomwise() runs, without waiting for its end. `input`: a file that is its
// standard input.
RunningProgram start_roomwise(const std::vector<std::string>& arguments,
                              const std::string& input = "/dev/null");

// Runs a command that must succeed and returns what it prints with --json.
nlohmann::json result_of(std::vector<std::string> arguments, const std::string& data_folder = {});

}  // namespace roomwise::testing
