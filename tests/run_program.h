#pragma once

#include <nlohmann/json.hpp>
#include <string>
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

// Runs a command that must succeed and returns what it prints with --json.
nlohmann::json result_of(std::vector<std::string> arguments, const std::string& data_folder = {});

}  // namespace roomwise::testing
