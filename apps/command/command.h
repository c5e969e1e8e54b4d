#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "interrupt.h"
#include "roomwise/base/expected.h"
#include "roomwise/base/thread_pool.h"
#include "terminal_progress.h"

namespace roomwise::app {

// Keeps its members in the order of writing, so that output reads as it was meant.
using Json = nlohmann::ordered_json;

inline constexpr std::size_t kMaxThreads = 1024;

// What a command found, in both forms: lines for people, and JSON for machines (--json). The frame
// prints one of them on standard output; nothing else is ever written there.
struct Answer {
  std::string text;  // lines, each with its line end
  Json json;
  bool is_good =
      true;  // otherwise the exit code is 1, though all was done: a check found something
};

// What every command is given: the options that all commands share, and the means to report.
struct Context {
  bool json = false;
  std::filesystem::path json_file;  // where the JSON is written too; empty: nowhere
  std::uint64_t seed = 0;
  std::size_t threads = ThreadPool::default_size();
  std::filesystem::path passphrase_file;  // of a protected home; empty: none was given
  TerminalProgress progress{interrupt_requested};
  // What is done before any command, once the command line has been read; none: nothing.
  std::function<Expected<void>()> prepare;
  // The body of the command on the command line; set while it is read, run afterwards.
  std::function<Expected<Answer>()> chosen;
};

// Makes a command of `command`: gives it the options that every command has (--json, --json-file,
// --seed, --threads, --passphrase-file) and `example` at the foot of its --help. The caller adds
// the command's own options. `body` runs once the whole command line has been read; its error
// becomes "roomwise: MESSAGE" on standard error and exit code 1.
void make_command(CLI::App& command, Context& context, const std::string& example,
                  std::function<Expected<Answer>()> body);

// The same with options of the command's own, which live as long as `command`: gives them, for the
// caller to tie them to the command line.
template <typename Options>
Options& make_command(CLI::App& command, Context& context, const std::string& example,
                      Expected<Answer> (*body)(const Options&, Context&)) {
  const auto options = std::make_shared<Options>();
  make_command(command, context, example,
               [options, body, &context] { return body(*options, context); });
  return *options;
}

// Declares the command NAME under `parent`, and makes one of it.
CLI::App* add_command(CLI::App& parent, Context& context, const std::string& name,
                      const std::string& description, const std::string& example,
                      std::function<Expected<Answer>()> body);
template <typename Options>
std::pair<CLI::App*, Options&> add_command(CLI::App& parent, Context& context,
                                           const std::string& name, const std::string& description,
                                           const std::string& example,
                                           Expected<Answer> (*body)(const Options&, Context&)) {
  CLI::App* const command = parent.add_subcommand(name, description);
  return {command, make_command(*command, context, example, body)};
}

// An option whose default --help shows, and what its value must be.
template <typename Value, typename... Checks>
CLI::Option* add_setting(CLI::App& command, const std::string& name, Value& value,
                         const std::string& meaning, const Checks&... checks) {
  CLI::Option* const option = command.add_option(name, value, meaning)->capture_default_str();
  (option->check(checks), ...);
  return option;
}

// Declares NAME as a word that only groups commands: "rooms" of "rooms learn".
CLI::App* add_group(CLI::App& parent, const std::string& name, const std::string& description,
                    const std::string& example);

// Checks for numbers on the command line.
CLI::Validator not_negative();
CLI::Validator positive();

// Reads the command line, runs the command and prints its answer. Returns the exit code: 0, 1 where
// the work failed, 2 where the command line is wrong.
int run(CLI::App& app, Context& context, int argc, const char* const* argv);

}  // namespace roomwise::app
