#include "command_description.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "roomwise/base/file.h"

namespace roomwise::app {
namespace {

// CLI11 says choices as a part of the value's type: "TEXT:{auto,float}".
std::vector<std::string> choices_in(const std::string& type) {
  const std::size_t begin = type.find('{');
  const std::size_t end = type.find('}', begin);
  std::vector<std::string> choices;
  if (begin == std::string::npos || end == std::string::npos) return choices;
  std::string choice;
  for (const char c : type.substr(begin + 1, end - begin - 1) + ",") {
    if (c != ',') {
      choice += c;
    } else {
      choices.push_back(std::exchange(choice, {}));
    }
  }
  return choices;
}

OptionDescription describe_option(const CLI::Option& option) {
  OptionDescription described;
  if (option.get_positional()) {
    described.names.push_back(option.get_name(true));
  } else {
    for (const std::string& name : option.get_snames()) described.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) described.names.push_back("--" + name);
  }
  described.takes_value = option.get_items_expected_max() > 0;
  described.is_repeated = option.get_items_expected_max() > 1;
  described.is_required = option.get_required();
  described.choices = choices_in(option.get_type_name());
  described.default_value = option.get_default_str();
  described.variable = option.get_envname();
  described.meaning = option.get_description();
  return described;
}

// The lines of a foot "Example:\n  roomwise map ...".
std::string example_in(const std::string& footer) {
  const std::string begin = "Example:\n";
  const std::size_t at = footer.find(begin);
  if (at == std::string::npos) return {};
  std::string example;
  std::size_t line = at + begin.size();
  while (line < footer.size() && footer.compare(line, 2, "  ") == 0) {
    const std::size_t end = std::min(footer.find('\n', line), footer.size());
    example += (example.empty() ? "" : "\n") + footer.substr(line + 2, end - line - 2);
    line = end + 1;
  }
  return example;
}

Json to_json(const OptionDescription& option) {
  return {{"names", option.names},
          {"takes_value", option.takes_value},
          {"repeated", option.is_repeated},
          {"required", option.is_required},
          {"choices", option.choices},
          {"default", option.default_value.empty() ? Json(nullptr) : Json(option.default_value)},
          {"environment", option.variable.empty() ? Json(nullptr) : Json(option.variable)},
          {"meaning", option.meaning}};
}

Json to_json(const std::vector<OptionDescription>& options) {
  Json json = Json::array();
  for (const OptionDescription& option : options) json.push_back(to_json(option));
  return json;
}

void collect(const CommandDescription& command, std::vector<const CommandDescription*>& all) {
  all.push_back(&command);
  for (const CommandDescription& below : command.commands) collect(below, all);
}

std::string last_word(const std::string& path) {
  return path.substr(path.rfind(' ') + 1);
}

// In single quotes of a shell.
std::string quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

// What may follow a command.
std::vector<std::string> words_after(const CommandDescription& command) {
  std::vector<std::string> words;
  for (const CommandDescription& below : command.commands) words.push_back(last_word(below.path));
  for (const OptionDescription& option : command.options) {
    words.insert(words.end(), option.names.begin(), option.names.end());
  }
  return words;
}

// The branches of a bash script's case "$command $prev" for one command.
std::string bash_values(const CommandDescription& command) {
  std::string branches;
  for (const OptionDescription& option : command.options) {
    if (!option.takes_value) continue;
    std::vector<std::string> patterns;
    for (const std::string& name : option.names) {
      patterns.push_back(fmt::format("\"{} {}\"", command.path, name));
    }
    const std::string reply = option.choices.empty()
                                  ? ""
                                  : fmt::format("COMPREPLY=($(compgen -W \"{}\" -- \"$cur\")); ",
                                                fmt::join(option.choices, " "));
    branches += fmt::format("    {}) {}return ;;\n", fmt::join(patterns, " | "), reply);
  }
  return branches;
}

// In the text of a zsh specification, whose own signs are escaped.
std::string zsh_text(std::string text) {
  std::string escaped;
  for (const char c : text.substr(0, text.find('\n'))) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

std::string zsh_value(const OptionDescription& option) {
  if (!option.takes_value) return "";
  if (option.choices.empty()) return ":value:_files";
  return fmt::format(":value:({})", fmt::join(option.choices, " "));
}

std::string zsh_options(const CommandDescription& command) {
  std::string specifications;
  for (const OptionDescription& option : command.options) {
    for (const std::string& name : option.names) {
      specifications += " " + quoted(fmt::format("{}{}[{}]{}", option.is_repeated ? "*" : "", name,
                                                 zsh_text(option.meaning), zsh_value(option)));
    }
  }
  return specifications;
}

std::string zsh_commands(const CommandDescription& command) {
  std::string described;
  for (const CommandDescription& below : command.commands) {
    described += " " + quoted(fmt::format("{}:{}", last_word(below.path), zsh_text(below.does)));
  }
  return described;
}

// Which command the words before the cursor name, in both shells' words.
std::string command_patterns(const std::vector<const CommandDescription*>& all) {
  std::vector<std::string> patterns;
  for (const CommandDescription* command : all) patterns.push_back('"' + command->path + '"');
  return fmt::format("{}", fmt::join(patterns, " | "));
}

// Text of a manual page: what the macros would take for their own is escaped.
std::string roff(const std::string& text) {
  std::string escaped;
  bool is_line_begin = true;
  for (const char c : text) {
    if (is_line_begin && (c == '.' || c == '\'')) escaped += "\\&";
    if (c == '\\') {
      escaped += "\\e";
    } else if (c == '-') {
      escaped += "\\-";
    } else {
      escaped += c;
    }
    is_line_begin = c == '\n';
  }
  return escaped;
}

// A sentence, though many meanings end without a full stop.
std::string sentence(const std::string& text) {
  const bool has_end = text.empty() || text.ends_with('.') || text.ends_with(']');
  return text + (has_end ? "\n" : ".\n");
}

std::string manual_options(const std::vector<OptionDescription>& options) {
  std::string text;
  for (const OptionDescription& option : options) {
    const bool is_operand = !option.names.front().starts_with('-');
    text += fmt::format(
        ".TP\n\\fB{}\\fR{}\n{}", roff(fmt::format("{}", fmt::join(option.names, ", "))),
        option.takes_value && !is_operand ? " \\fIVALUE\\fR" : "", roff(sentence(option.meaning)));
    if (!option.choices.empty()) {
      text += roff(fmt::format("One of: {}.\n", fmt::join(option.choices, ", ")));
    }
    if (!option.default_value.empty()) {
      text += roff(fmt::format("Default: {}.\n", option.default_value));
    }
    if (!option.variable.empty()) {
      text += roff(fmt::format("Environment: {}.\n", option.variable));
    }
    if (option.is_required) text += "Must be given.\n";
  }
  return text;
}

std::string hyphenated(std::string path) {
  std::ranges::replace(path, ' ', '-');
  return path;
}

}  // namespace

CommandDescription describe_command(const CLI::App& command, const std::string& path) {
  CommandDescription described{
      path, command.get_description(), example_in(command.get_footer()), {}, {}, {}};
  for (const CLI::Option* option : command.get_options()) {
    auto& list = option->get_positional() ? described.operands : described.options;
    list.push_back(describe_option(*option));
  }
  for (const CLI::App* below : command.get_subcommands([](const CLI::App*) { return true; })) {
    // An option group is no command: it has no name to be called by, and no help of its own.
    if (below->get_name().empty()) {
      for (const CLI::Option* option : below->get_options()) {
        if (option == below->get_help_ptr()) continue;
        auto& list = option->get_positional() ? described.operands : described.options;
        list.push_back(describe_option(*option));
      }
      continue;
    }
    described.commands.push_back(describe_command(*below, path + " " + below->get_name()));
  }
  return described;
}

Json to_json(const CommandDescription& command) {
  Json json = {{"command", command.path},
               {"does", command.does},
               {"example", command.example},
               {"options", to_json(command.options)},
               {"operands", to_json(command.operands)},
               {"commands", Json::array()}};
  for (const CommandDescription& below : command.commands) {
    json["commands"].push_back(to_json(below));
  }
  return json;
}

std::string bash_completion(const CommandDescription& program) {
  std::vector<const CommandDescription*> all;
  collect(program, all);
  std::string words, values;
  for (const CommandDescription* command : all) {
    words += fmt::format("    \"{}\") words=\"{}\" ;;\n", command->path,
                         fmt::join(words_after(*command), " "));
    values += bash_values(*command);
  }
  // A reply of nothing makes readline complete files (-o default).
  return fmt::format(
      "# Completes {0} in bash; written by {0} itself.\n"
      "_{0}() {{\n"
      "  local cur=${{COMP_WORDS[COMP_CWORD]}} prev=${{COMP_WORDS[COMP_CWORD - 1]}} command={0} "
      "words= i\n"
      "  for ((i = 1; i < COMP_CWORD; ++i)); do\n"
      "    case \"$command ${{COMP_WORDS[i]}}\" in\n"
      "    {1}) command+=\" ${{COMP_WORDS[i]}}\" ;;\n"
      "    esac\n"
      "  done\n"
      "  COMPREPLY=()\n"
      "  case \"$command $prev\" in\n{2}  esac\n"
      "  case \"$command\" in\n{3}  esac\n"
      "  COMPREPLY=($(compgen -W \"$words\" -- \"$cur\"))\n"
      "}}\n"
      "complete -o default -F _{0} {0}\n",
      program.path, command_patterns(all), values, words);
}

std::string zsh_completion(const CommandDescription& program) {
  std::vector<const CommandDescription*> all;
  collect(program, all);
  std::string branches;
  for (const CommandDescription* command : all) {
    branches += fmt::format("    \"{}\")\n", command->path);
    if (!command->commands.empty()) {
      branches += fmt::format("      below=({})\n      _describe command below\n",
                              zsh_commands(*command).substr(1));
    }
    branches +=
        fmt::format("      _arguments{} '*:file:_files'\n      ;;\n", zsh_options(*command));
  }
  return fmt::format(
      "#compdef {0}\n"
      "# Completes {0} in zsh; written by {0} itself.\n"
      "_{0}() {{\n"
      "  local command={0} i\n"
      "  local -a below\n"
      "  for ((i = 2; i < CURRENT; ++i)); do\n"
      "    case \"$command $words[i]\" in\n"
      "    {1}) command+=\" $words[i]\" ;;\n"
      "    esac\n"
      "  done\n"
      "  case \"$command\" in\n{2}  esac\n"
      "}}\n"
      "_{0} \"$@\"\n",
      program.path, command_patterns(all), branches);
}

std::string manual_page(const CommandDescription& command, const std::string& version) {
  const std::string name = hyphenated(command.path);
  std::string upper = name;
  std::ranges::transform(upper, upper.begin(), [](char c) {
    return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  });
  const std::string first_line = command.does.substr(0, command.does.find('\n'));
  std::string page = fmt::format(".TH \"{}\" 1 \"\" \"Roomwise {}\"\n.SH NAME\n{} \\- {}\n",
                                 roff(upper), version, roff(name), roff(first_line));
  page += fmt::format(".SH SYNOPSIS\n\\fB{}\\fR", roff(command.path));
  if (!command.options.empty()) page += " [\\fIOPTION\\fR ...]";
  for (const OptionDescription& operand : command.operands) {
    page += fmt::format(" \\fI{}\\fR{}", roff(operand.names.front()),
                        operand.is_repeated ? " ..." : "");
  }
  if (!command.commands.empty()) page += " \\fICOMMAND\\fR ...";
  page += fmt::format("\n.SH DESCRIPTION\n{}\n", roff(command.does));
  if (!command.commands.empty()) page += ".SH COMMANDS\n";
  for (const CommandDescription& below : command.commands) {
    page += fmt::format(".TP\n\\fB{}\\fR\n{}\n", roff(last_word(below.path)), roff(below.does));
  }
  if (!command.operands.empty()) page += ".SH OPERANDS\n" + manual_options(command.operands);
  if (!command.options.empty()) page += ".SH OPTIONS\n" + manual_options(command.options);
  if (!command.example.empty()) {
    page += fmt::format(".SH EXAMPLE\n.nf\n{}\n.fi\n", roff(command.example));
  }
  page +=
      ".SH EXIT STATUS\n0; 1 where the work failed, with the reason on standard error; 2 where the "
      "command line is wrong.\n";
  std::vector<std::string> others;
  if (command.path.find(' ') != std::string::npos) {
    others.push_back(hyphenated(command.path.substr(0, command.path.rfind(' '))));
  }
  for (const CommandDescription& below : command.commands) others.push_back(hyphenated(below.path));
  if (others.empty()) return page;
  for (std::string& other : others) other = fmt::format("\\fB{}\\fR(1)", roff(other));
  return page + fmt::format(".SH SEE ALSO\n{}\n", fmt::join(others, ", "));
}

Expected<std::size_t> write_manual(const CommandDescription& command, const std::string& version,
                                   const std::filesystem::path& folder) {
  ROOMWISE_RETURN_IF_ERROR(
      write_file(folder / (hyphenated(command.path) + ".1"), manual_page(command, version)));
  std::size_t pages = 1;
  for (const CommandDescription& below : command.commands) {
    ROOMWISE_TRY(const std::size_t more, write_manual(below, version, folder));
    pages += more;
  }
  return pages;
}

Expected<void> write_help(const CLI::App& app, const std::string& program,
                          const std::string& version, const std::filesystem::path& folder) {
  const std::filesystem::path manual = folder / "man1";
  std::error_code error;
  std::filesystem::create_directories(manual, error);
  if (error) return fail("{}: cannot be made: {}", manual.string(), error.message());
  const CommandDescription all = describe_command(app, program);
  ROOMWISE_RETURN_IF_ERROR(write_file(folder / (program + ".bash"), bash_completion(all)));
  ROOMWISE_RETURN_IF_ERROR(write_file(folder / ("_" + program), zsh_completion(all)));
  const CommandDescription described = describe_command(app, app.get_name());
  std::vector<CommandDescription> pages{described};
  if (app.get_name() != program) pages = described.commands;
  for (const CommandDescription& page : pages)
    ROOMWISE_RETURN_IF_ERROR(write_manual(page, version, manual));
  return {};
}

}  // namespace roomwise::app
