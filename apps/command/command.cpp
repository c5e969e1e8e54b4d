#include "command.h"

#include <cmath>
#include <filesystem>
#include <iostream>
#include <new>

#include "command_description.h"
#include "roomwise/base/file.h"
#include "roomwise/base/simd.h"

namespace roomwise::app {
namespace {

constexpr int kDone = 0;
constexpr int kFailed = 1;
constexpr int kUsage = 2;

// "roomwise rooms learn": the command that the user had reached when reading stopped.
std::string reached_command(const CLI::App& app) {
  std::string path = app.get_name();
  const CLI::App* command = &app;
  while (!command->get_subcommands().empty()) {
    command = command->get_subcommands().front();
    path += " " + command->get_name();
  }
  return path;
}

// What is wrong with the command line. A word that nothing takes is named first: it explains better
// than what CLI11 misses instead of it.
std::string describe(const CLI::App& app, const CLI::ParseError& error) {
  const std::vector<std::string> unknown = app.remaining(true);
  if (unknown.empty() || unknown.front() == "--") return error.what();
  const bool is_option = unknown.front().starts_with('-');
  return fmt::format("'{}' is not {}", unknown.front(),
                     is_option ? "an option here" : "expected here");
}

// CLI11's messages may run over several lines; an error is one.
std::string on_one_line(std::string message) {
  while (!message.empty() && message.back() == '\n') message.pop_back();
  for (char& c : message) {
    if (c == '\n') c = ' ';
  }
  return message;
}

int print_failure(std::string_view message) {
  std::cerr << "roomwise: " << message << '\n';
  return kFailed;
}

int print_answer(const Answer& answer, const Context& context) {
  // Names of files need not be UTF-8; JSON must.
  const std::string json = answer.json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  std::cout << (context.json ? json : answer.text);
  std::cout.flush();
  if (!std::cout) return print_failure("standard output: cannot be written");
  if (!context.json_file.empty()) {
    const Expected<void> written = write_file(context.json_file, json);
    if (!written) return print_failure(written.error().message);
  }
  return answer.is_good ? kDone : kFailed;
}

Expected<Answer> carry_out(const std::function<Expected<Answer>()>& body) {
  try {
    return body();
  } catch (const std::filesystem::filesystem_error& fault) {  // a folder that may not be searched
    return fail("{}: {}", fault.path1().string(), fault.code().message());
  } catch (const std::bad_alloc&) {
    return fail("there is not enough memory for this");
  } catch (const std::exception& fault) {
    return fail("internal error, please report it: {}", fault.what());
  }
}

// CLI11's own checks of ranges name the largest double there is. What is no number at all is left
// to the conversion that follows.
CLI::Validator number_that(bool (*is_right)(double), const std::string& demand) {
  return CLI::Validator(
      [is_right, demand](const std::string& text) {
        double value = 0;
        const bool is_number = CLI::detail::lexical_cast(text, value);
        return is_number && !is_right(value) ? fmt::format("{} {}", text, demand) : std::string();
      },
      "");
}

// An option that may be repeated takes one value each time: "--network a.onnx walk" must not take
// the recording for a second network. And no count is negative.
void settle_options(CLI::App& app) {
  for (CLI::Option* option : app.get_options()) {
    if (!option->get_positional()) option->allow_extra_args(false);
    // CLI11 reads -1 as the largest number there is.
    if (option->get_type_name().starts_with("UINT")) option->check(not_negative());
  }
  for (CLI::App* command : app.get_subcommands({})) settle_options(*command);
}

}  // namespace

void make_command(CLI::App& command, Context& context, const std::string& example,
                  std::function<Expected<Answer>()> body) {
  command.footer("Example:\n  " + example);
  command.add_flag("--json", context.json, "Print the result as JSON");
  command.add_option("--json-file", context.json_file, "Also write the result there, as JSON")
      ->type_name("FILE");
  command.add_option("--seed", context.seed, "Seed of everything random; same seed, same result")
      ->type_name("N")
      ->check(not_negative())
      ->capture_default_str();
  command.add_option("--threads", context.threads, "Threads to use (default: all processors)")
      ->type_name("N")
      ->check(CLI::Range(std::size_t{1}, kMaxThreads).description(""));
  command
      .add_option("--passphrase-file", context.passphrase_file,
                  "File with the passphrase of a home whose pictures are protected")
      ->type_name("FILE")
      ->envname("ROOMWISE_PASSPHRASE_FILE");
  command.callback([&context, body = std::move(body)] { context.chosen = body; });
}

CLI::App* add_command(CLI::App& parent, Context& context, const std::string& name,
                      const std::string& description, const std::string& example,
                      std::function<Expected<Answer>()> body) {
  CLI::App* command = parent.add_subcommand(name, description);
  make_command(*command, context, example, std::move(body));
  return command;
}

CLI::App* add_group(CLI::App& parent, const std::string& name, const std::string& description,
                    const std::string& example) {
  CLI::App* group = parent.add_subcommand(name, description);
  group->require_subcommand(1);
  group->footer("Example:\n  " + example);
  return group;
}

CLI::Validator not_negative() {
  return number_that([](double value) { return value >= 0 && std::isfinite(value); },
                     "must not be negative, and finite");
}

CLI::Validator positive() {
  // Seconds are counted in nanoseconds, and nothing that is asked for is more.
  return number_that([](double value) { return value > 0 && value <= 1e9; },
                     "must be positive, and at most 1000000000");
}

int run(CLI::App& app, Context& context, int argc, const char* const* argv) {
  settle_options(app);
  // Asked by the build alone, which installs what is written.
  if (argc == 3 && std::string_view(argv[1]) == "--write-help") {
    const std::string program = std::filesystem::path(argv[0]).filename().string();
    const auto written = write_help(app, program, app.version(), argv[2]);
    return written ? kDone : print_failure(on_one_line(written.error().message));
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help_or_version) {
    return app.exit(help_or_version);
  } catch (const CLI::ParseError& error) {
    std::cerr << "roomwise: " << on_one_line(describe(app, error)) << "; run '"
              << reached_command(app) << " --help' to see how it is used\n";
    return kUsage;
  }
  if (const auto simd = simd_of_environment(); !simd) return print_failure(simd.error().message);
  if (context.prepare) {
    if (const auto prepared = context.prepare(); !prepared)
      return print_failure(on_one_line(prepared.error().message));
  }
  const Expected<Answer> answer = carry_out(context.chosen);
  context.progress.finish_line();
  if (!answer) return print_failure(on_one_line(answer.error().message));
  return print_answer(*answer, context);
}

}  // namespace roomwise::app
