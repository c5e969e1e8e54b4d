#include <filesystem>
#include <vector>

#include "commands.h"
#include "open_home.h"

namespace roomwise::app {
namespace {

struct CheckOptions {
  std::filesystem::path home;
};

std::vector<home::KeyframeId> keyframes_of(const home::HomeCheck& check) {
  std::vector<home::KeyframeId> ids;
  for (const auto& [id, why] : check.lost_pictures) ids.push_back(id);
  return ids;
}

std::string for_people(const home::Home& home, const home::HomeCheck& check) {
  std::string text =
      fmt::format("{}: {}\n", home.file(), check.is_whole() ? "is whole" : "is damaged");
  const auto line = [&](const std::string& what) { text += "  " + what + "\n"; };
  if (!check.damaged_pages.empty()) {
    line(fmt::format("{} of its {} pages differ from their checksums", check.damaged_pages.size(),
                     check.pages));
  }
  for (const std::string& table : check.damaged_tables)
    line(fmt::format("table '{}' cannot be read in full", table));
  if (!check.lost_pictures.empty()) {
    line(fmt::format("the images of {} key-frames cannot be read: {}", check.lost_pictures.size(),
                     fmt::join(keyframes_of(check), ", ")));
  }
  for (const std::string& table : check.broken_references)
    line(fmt::format("a row of table '{}' belongs to one that is not there", table));
  for (const std::string& camera : check.doubtful_cameras)
    line(fmt::format("note: the camera of {}", camera));
  if (home.is_locked()) {
    line(
        "note: whether its sealed pictures were changed was not looked at; give "
        "--passphrase-file");
  }
  if (!check.is_whole()) {
    line(
        "put back a copy of it (roomwise restore); what is not named above is whole, and of a copy "
        "of this file can be read with: sqlite3 COPY .recover");
  }
  return text;
}

Expected<Answer> check(const CheckOptions& options, Context& context) {
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  ROOMWISE_TRY(const home::HomeCheck found, home.check());
  return Answer{for_people(home, found),
                {{"home", home.file()},
                 {"whole", found.is_whole()},
                 {"pages", found.pages},
                 {"damaged_pages", found.damaged_pages},
                 {"damaged_tables", found.damaged_tables},
                 {"lost_pictures", keyframes_of(found)},
                 {"broken_references", found.broken_references},
                 {"doubtful_cameras", found.doubtful_cameras},
                 {"seals_checked", home.is_protected() && !home.is_locked()}},
                found.is_whole()};
}

}  // namespace

void add_check_command(CLI::App& app, Context& context) {
  const auto [command, options] = add_command<CheckOptions>(
      app, context, "check",
      "Read a home's whole file, pictures too, and say what of it is damaged; the exit code is 1 "
      "where something is",
      "roomwise check my.home", check);
  command->add_option("HOME", options.home, "Home file")->required();
}

}  // namespace roomwise::app
