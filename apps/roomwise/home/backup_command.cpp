#include <filesystem>

#include "commands.h"
#include "open_home.h"
#include "roomwise/live/home/home_backup.h"

namespace roomwise::app {
namespace {

struct BackupOptions {
  std::filesystem::path home;
  std::filesystem::path folder;
  bool without_walks = false;
  bool without_devices = false;
};

std::string words_of(const live::Restored& restored) {
  if (restored.devices == 0) return "No device is paired with it";
  return fmt::format(
      "Paired with it: {} devices, as when the backup was made; remove who was removed since "
      "(--without-devices leaves all out)",
      restored.devices);
}

Expected<Answer> back_up(const BackupOptions& options, Context& context) {
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  ROOMWISE_TRY(const live::Backup backup,
               live::back_up(home, options.folder, {.with_walks = !options.without_walks}));
  return Answer{fmt::format("{}: {} files, {:.1f} MB, checked\n", options.folder.string(),
                            backup.files, static_cast<double>(backup.bytes) / 1e6),
                {{"home", home.file()},
                 {"backup", options.folder.string()},
                 {"files", backup.files},
                 {"bytes", backup.bytes}}};
}

Expected<Answer> restore(const BackupOptions& options, Context&) {
  ROOMWISE_TRY(
      const live::Restored backup,
      live::restore(options.folder, options.home, {.with_devices = !options.without_devices}));
  return Answer{
      fmt::format("{}: is back, {} files, {:.1f} MB\n{}\n", options.home.string(), backup.files,
                  static_cast<double>(backup.bytes) / 1e6, words_of(backup)),
      {{"home", options.home.string()},
       {"backup", options.folder.string()},
       {"devices", backup.devices},
       {"files", backup.files},
       {"bytes", backup.bytes}}};
}

}  // namespace

void add_backup_commands(CLI::App& app, Context& context) {
  const auto [backup, backup_options] = add_command<BackupOptions>(
      app, context, "backup",
      "Copy a home and what belongs to it (paired devices, photos, recorded walks) into a new "
      "folder, also while it is open to devices; what is copied is checked",
      "roomwise backup my.home -o my.home-sunday", back_up);
  backup->add_option("HOME", backup_options.home, "Home file")->required();
  backup->add_option("-o,--output", backup_options.folder, "New folder")->required();
  backup->add_flag("--without-walks", backup_options.without_walks,
                   "Without the recordings of walks, which are large; the home keeps what was made "
                   "of them");
  const auto [command, options] = add_command<BackupOptions>(
      app, context, "restore", "Put a home back from a backup, where there is none of its name",
      "roomwise restore my.home-sunday --home my.home", restore);
  command->add_option("FOLDER", options.folder, "Folder that roomwise backup made")->required();
  command->add_option("--home", options.home, "Home file to make")->required();
  command->add_flag(
      "--without-devices", options.without_devices,
      "Without the devices that were paired when the backup was made: pair each anew");
}

}  // namespace roomwise::app
