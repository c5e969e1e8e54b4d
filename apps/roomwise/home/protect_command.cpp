#include <unistd.h>

#include <filesystem>
#include <memory>

#include "commands.h"
#include "open_home.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

struct ProtectOptions {
  fs::path home;
  fs::path new_passphrase;
  bool change = false;
  bool remove = false;
};

bool can_ask() {
  return ::isatty(STDIN_FILENO) != 0;
}

// The home's passphrase, or the one that it is to get.
Expected<home::Passphrase> passphrase_of(const Context& context, bool is_protected) {
  if (!context.passphrase_file.empty()) return home::Passphrase::read(context.passphrase_file);
  if (!can_ask()) {
    return fail(
        "give the file that holds the passphrase by --passphrase-file, or run this at a "
        "terminal");
  }
  return is_protected ? ask_passphrase(STDIN_FILENO, "Passphrase")
                      : ask_new_passphrase(STDIN_FILENO);
}

Expected<home::Passphrase> new_passphrase_of(const ProtectOptions& options) {
  if (!options.new_passphrase.empty()) return home::Passphrase::read(options.new_passphrase);
  if (!can_ask()) return fail("give the file that holds the new passphrase: --new-passphrase-file");
  return ask_new_passphrase(STDIN_FILENO);
}

Answer to_answer(const home::Home& home, const std::string& text, std::size_t pictures) {
  return {home.file() + ": " + text + "\n",
          {{"home", home.file()}, {"protected", home.is_protected()}, {"pictures", pictures}}};
}

Expected<Answer> protect(const ProtectOptions& options, Context& context) {
  const bool changes = options.change || !options.new_passphrase.empty();
  ROOMWISE_TRY(const home::Home looked_at, home::Home::open_read_only(options.home));
  const bool was_protected = looked_at.is_protected();
  if ((options.remove || changes) && !was_protected) {
    return fail("{}: its pictures are not protected", options.home.string());
  }
  ROOMWISE_TRY(home::Passphrase passphrase, passphrase_of(context, was_protected));
  const auto given = std::make_shared<const home::Passphrase>(std::move(passphrase));
  ROOMWISE_TRY(home::Home home, home::Home::open(options.home, {was_protected ? given : nullptr}));
  if (options.remove) {
    ROOMWISE_TRY(const std::size_t pictures, home.unprotect(*given));
    return to_answer(home, fmt::format("{} pictures are no longer protected", pictures), pictures);
  }
  if (changes) {
    ROOMWISE_TRY(const home::Passphrase next, new_passphrase_of(options));
    ROOMWISE_TRY(const std::size_t pictures, home.protect(next));
    return to_answer(home, "its passphrase was changed", pictures);
  }
  ROOMWISE_TRY(const std::size_t pictures, home.protect(*given));
  return to_answer(home,
                   was_protected && pictures == 0
                       ? "its pictures were protected already"
                       : fmt::format("{} pictures are protected by the passphrase now; without it "
                                     "nobody can see them again",
                                     pictures),
                   pictures);
}

}  // namespace

void add_protect_command(CLI::App& app, Context& context) {
  const auto [command, options] = add_command<ProtectOptions>(
      app, context, "protect",
      "Protect the pictures in a home by a passphrase, change it, or take the protection away; "
      "run again, it finishes what was stopped",
      "roomwise protect my.home", protect);
  command->add_option("HOME", options.home, "Home file")->required();
  CLI::Option* remove = command->add_flag("--remove", options.remove, "Take the protection away");
  command
      ->add_flag("--change", options.change,
                 "Ask for another passphrase, which takes the place of the present one")
      ->excludes(remove);
  command
      ->add_option("--new-passphrase-file", options.new_passphrase,
                   "File with another passphrase, which takes the place of the present one")
      ->type_name("FILE")
      ->excludes(remove);
}

}  // namespace roomwise::app
