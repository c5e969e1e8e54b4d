#include <unistd.h>

#include <algorithm>
#include <array>
#include <ctime>

#include "commands.h"
#include "open_home.h"
#include "serving/serve_parts.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

struct AccountsOptions {
  fs::path homes;
  std::string accounts;
  std::string name;
  fs::path password_file;
  std::string home;
  std::string role;
  std::size_t lines = 50;
};

Expected<home::Passphrase> password_of(const AccountsOptions& options) {
  if (!options.password_file.empty()) return home::Passphrase::read(options.password_file);
  if (::isatty(STDIN_FILENO) == 0) {
    return fail(
        "give the file that holds the password by --password-file, or run this at a terminal");
  }
  return ask_new_passphrase(STDIN_FILENO);
}

std::string_view text_of(const home::Passphrase& password) {
  return {reinterpret_cast<const char*>(password.bytes().data()), password.bytes().size()};
}

std::string time_text(std::int64_t seconds) {
  const auto time = static_cast<std::time_t>(seconds);
  std::tm parts{};
  localtime_r(&time, &parts);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%F %T", &parts);
  return text.data();
}

// That it was done is kept like what staff does.
Expected<Answer> done(service::AccountStore& store, const AccountsOptions& options,
                      const std::string& what) {
  ROOMWISE_RETURN_IF_ERROR(store.note({seconds_since_1970(), "the computer's keeper", options.home,
                                       what + " " + options.name, "done", ""}));
  return Answer{fmt::format("{}: {}\n", options.name, what), {{"account", options.name}}};
}

Expected<Answer> add_account(const AccountsOptions& options, Context&) {
  ROOMWISE_TRY(const auto store, open_accounts(options.homes, options.accounts));
  ROOMWISE_TRY(const home::Passphrase password, password_of(options));
  ROOMWISE_RETURN_IF_ERROR(store->add(options.name, text_of(password)));
  return done(*store, options, "account added");
}

Expected<Answer> set_password(const AccountsOptions& options, Context&) {
  ROOMWISE_TRY(const auto store, open_accounts(options.homes, options.accounts));
  ROOMWISE_TRY(const home::Passphrase password, password_of(options));
  ROOMWISE_RETURN_IF_ERROR(store->set_password(options.name, text_of(password)));
  return done(*store, options, "password changed");
}

Expected<Answer> set_role(const AccountsOptions& options, Context&) {
  ROOMWISE_TRY(const auto role, service::parse_staff_role(options.role));
  std::error_code error;
  if (role && !fs::exists(options.homes / (options.home + ".home"), error)) {
    return fail("{}: there is no home '{}'", options.homes.string(), options.home);
  }
  ROOMWISE_TRY(const auto store, open_accounts(options.homes, options.accounts));
  ROOMWISE_RETURN_IF_ERROR(store->set_role(options.name, options.home, role));
  return done(*store, options, fmt::format("role {} in {}", options.role, options.home));
}

Expected<Answer> remove_account(const AccountsOptions& options, Context&) {
  ROOMWISE_TRY(const auto store, open_accounts(options.homes, options.accounts));
  ROOMWISE_RETURN_IF_ERROR(store->remove(options.name));
  return done(*store, options, "account removed");
}

Expected<Answer> list_accounts(const AccountsOptions& options, Context&) {
  ROOMWISE_TRY(const auto store, open_accounts(options.homes, options.accounts));
  ROOMWISE_TRY(const auto accounts, store->accounts());
  Answer answer;
  answer.json = Json{{"accounts", Json::array()}};
  for (const service::Account& account : accounts) {
    answer.text += account.name + "\n";
    Json homes = Json::object();
    for (const auto& [home, role] : account.homes) {
      answer.text += fmt::format("  {}: {}\n", home, to_string(role));
      homes[home] = to_string(role);
    }
    answer.json["accounts"].push_back({{"name", account.name}, {"homes", homes}});
  }
  if (accounts.empty()) answer.text = "there are no accounts yet\n";
  return answer;
}

Expected<Answer> show_audit(const AccountsOptions& options, Context&) {
  ROOMWISE_TRY(const auto store, open_accounts(options.homes, options.accounts));
  ROOMWISE_TRY(auto lines, store->audit(options.lines, options.home));
  std::ranges::reverse(lines);
  Answer answer;
  answer.json = Json{{"lines", Json::array()}};
  for (const service::AuditLine& line : lines) {
    answer.text += fmt::format("{}  {}  {}  {}: {}  {}\n", time_text(line.time_s), line.who,
                               line.home.empty() ? "-" : line.home, line.what, line.outcome,
                               line.peer.empty() ? "-" : line.peer);
    answer.json["lines"].push_back({{"time", line.time_s},
                                    {"who", line.who},
                                    {"home", line.home},
                                    {"what", line.what},
                                    {"outcome", line.outcome},
                                    {"peer", line.peer}});
  }
  return answer;
}

void add_one(CLI::App& group, Context& context, const std::string& name,
             const std::string& description, const std::string& example,
             Expected<Answer> (*body)(const AccountsOptions&, Context&), bool of_account,
             bool with_password = false) {
  const auto [command, options] =
      add_command<AccountsOptions>(group, context, name, description, example, body);
  command->add_option("FOLDER", options.homes, "Folder of homes")->required();
  if (of_account) {
    command->add_option("NAME", options.name, "The account's name")->required();
  }
  if (with_password) {
    command->add_option("--password-file", options.password_file,
                        "File that holds the password; else it is asked for");
  }
  command->add_option("--accounts", options.accounts,
                      "postgresql://USER@HOST/DATABASE; default: a file in the folder");
  if (name == "role") {
    command->add_option("HOME", options.home, "Name of the home: flat-7 of flat-7.home")
        ->required();
    command->add_option("ROLE", options.role, "helper, device or none")
        ->required()
        ->check(CLI::IsMember({"helper", "device", "none"}));
  }
  if (name == "audit") {
    command->add_option("--home", options.home, "What was done in that home alone");
    add_setting(*command, "--lines", options.lines, "So many, the newest", positive());
  }
}

}  // namespace

void add_accounts_commands(CLI::App& app, Context& context) {
  CLI::App* const group =
      add_group(app, "accounts", "The staff of who keeps a folder of homes, and who did what",
                "roomwise accounts add homes anna");
  add_one(*group, context, "add", "Add an account", "roomwise accounts add homes anna", add_account,
          true, true);
  add_one(*group, context, "password", "Give an account another password",
          "roomwise accounts password homes anna", set_password, true, true);
  add_one(*group, context, "role", "Say what an account may do in a home",
          "roomwise accounts role homes anna flat-7 helper", set_role, true);
  add_one(*group, context, "remove", "Remove an account", "roomwise accounts remove homes anna",
          remove_account, true);
  add_one(*group, context, "list", "List the accounts and what they may",
          "roomwise accounts list homes", list_accounts, false);
  add_one(*group, context, "audit", "Show who did what, and when",
          "roomwise accounts audit homes --home flat-7", show_audit, false);
}

}  // namespace roomwise::app
