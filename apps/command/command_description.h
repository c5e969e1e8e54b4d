#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "command.h"

namespace roomwise::app {

// An option or an operand, as --help has it.
struct OptionDescription {
  std::vector<std::string> names;  // "-o", "--output"; of an operand its one name, "RECORDING"
  bool takes_value = true;         // not of a flag
  bool is_repeated = false;        // takes several values, or may be given several times
  bool is_required = false;
  std::vector<std::string> choices;  // all values that it may have; empty: anything
  std::string default_value;         // empty: none that can be told
  std::string variable;              // of the environment, that gives it, too; empty: none
  std::string meaning;
};

// A command and those below it.
struct CommandDescription {
  std::string path;  // "roomwise rooms learn"
  std::string does;
  std::string example;                      // command lines, without indentation
  std::vector<OptionDescription> options;   // empty where another program knows them
  std::vector<OptionDescription> operands;  // in their order
  std::vector<CommandDescription> commands;
};

[[nodiscard]] CommandDescription describe_command(const CLI::App& command, const std::string& path);
[[nodiscard]] Json to_json(const CommandDescription& command);

// Scripts by which a shell completes commands, options and the values of those that have choices;
// anything else is completed as a file.
[[nodiscard]] std::string bash_completion(const CommandDescription& program);
[[nodiscard]] std::string zsh_completion(const CommandDescription& program);
// The manual page of one command, in the man macros; `version`: of the program.
[[nodiscard]] std::string manual_page(const CommandDescription& command,
                                      const std::string& version);
// Writes those of a command and of all below it, "roomwise-rooms-learn.1", and says how many.
[[nodiscard]] Expected<std::size_t> write_manual(const CommandDescription& command,
                                                 const std::string& version,
                                                 const std::filesystem::path& folder);

// What a program is installed with, as it says of itself: PROGRAM.bash, _PROGRAM and man1/.
// "roomwise-train" is a part of "roomwise": it has pages of its commands alone.
[[nodiscard]] Expected<void> write_help(const CLI::App& app, const std::string& program,
                                        const std::string& version,
                                        const std::filesystem::path& folder);

}  // namespace roomwise::app
