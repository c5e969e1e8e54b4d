#include <filesystem>

#include "command_description.h"
#include "commands.h"

namespace roomwise::app {
namespace {

struct HelpOptions {
  std::vector<std::string> command;
  std::string as = "text";
  std::filesystem::path manual;  // a folder for manual pages; empty: none
};

// The command of these words, and its path.
struct Named {
  const CLI::App* command = nullptr;
  std::string path;
};

Expected<Named> find_command(const CLI::App& program, const std::vector<std::string>& words) {
  Named named{&program, program.get_name()};
  for (const std::string& word : words) {
    const auto below = named.command->get_subcommands([](const CLI::App*) { return true; });
    const auto found =
        std::ranges::find(below, word, [](const CLI::App* one) { return one->get_name(); });
    if (found == below.end()) {
      return fail("'{}' is no command of {}; run '{} --help' to see those that there are", word,
                  named.path, named.path);
    }
    named = {*found, named.path + " " + word};
  }
  return named;
}

Expected<Answer> help(const CLI::App& program, const HelpOptions& options) {
  ROOMWISE_TRY(const Named named, find_command(program, options.command));
  const CommandDescription described = describe_command(*named.command, named.path);
  Answer answer{"", to_json(described)};
  if (!options.manual.empty()) {
    ROOMWISE_TRY(const std::size_t pages,
                 write_manual(described, ROOMWISE_VERSION, options.manual));
    answer.text = fmt::format("wrote {} manual pages to {}\n", pages, options.manual.string());
  } else if (options.as == "bash") {
    answer.text = bash_completion(described);
  } else if (options.as == "zsh") {
    answer.text = zsh_completion(described);
  } else if (options.as == "man") {
    answer.text = manual_page(described, ROOMWISE_VERSION);
  } else {
    const std::size_t parent_end = named.path.rfind(' ');
    answer.text = named.command->help(
        parent_end == std::string::npos ? "" : named.path.substr(0, parent_end));
  }
  return answer;
}

}  // namespace

void add_help_command(CLI::App& app, Context& context) {
  const auto options = std::make_shared<HelpOptions>();
  CLI::App* const command =
      add_command(app, context, "help",
                  "Explain a command, to people, to programs (--json), to a shell or to man",
                  "roomwise help rooms learn\n"
                  "  roomwise help --as bash > ~/.local/share/bash-completion/completions/roomwise",
                  [options, &app] { return help(app, *options); });
  command->add_option("COMMAND", options->command, "Its words; default: the whole program");
  command
      ->add_option(
          "--as", options->as,
          "text; bash or zsh: a script that completes its command line; man: its manual page")
      ->check(CLI::IsMember({"text", "bash", "zsh", "man"}))
      ->capture_default_str();
  command->add_option("--manual", options->manual,
                      "Write the manual pages of it and of all commands below it to this folder");
}

}  // namespace roomwise::app
