#include <algorithm>
#include <filesystem>

#include "command_run.h"
#include "commands.h"
#include "open_home.h"
#include "roomwise/pipeline/edits/walk_edits.h"
#include "roomwise/pipeline/mapping/home_floor.h"
#include "roomwise/pipeline/stored/stored_map.h"

namespace roomwise::app {
namespace {

struct ForgetOptions {
  std::filesystem::path home;
  std::string walk;
};

Expected<Answer> forget(const ForgetOptions& options, Context& context) {
  ROOMWISE_TRY(home::Home home, open_home(options.home, context));
  ROOMWISE_TRY(const auto recordings, home.recordings());
  if (options.walk.empty()) return fail("an empty name is no walk's");
  ROOMWISE_TRY(const home::RecordingId walk, find_walk(home, options.walk));
  const auto found = std::ranges::find(recordings, walk, &home::StoredRecording::id);
  const std::string name = found->recording.name;
  ROOMWISE_TRY(const auto learned, home.room_classifier());
  ROOMWISE_RETURN_IF_ERROR(pipeline::remove_walk_folder(home, *found));
  ROOMWISE_RETURN_IF_ERROR(pipeline::forget_walk(home, walk));
  ROOMWISE_RETURN_IF_ERROR(home.erase_removed());
  ROOMWISE_TRY(const auto left, home.keyframes());
  if (!left.empty() && !home.is_locked()) {
    // The walk is gone whatever comes of this.
    CommandRun run(context);
    if (const auto kept = pipeline::keep_home_floor(home, run); !kept) {
      context.progress.note(
          fmt::format("the floor is found when it is asked for: {}", kept.error().message));
    }
  }
  return Answer{
      fmt::format(
          "{}: {} is forgotten, its pictures are erased; {} key-frames of {} walks are left{}\n",
          home.file(), name, left.size(), recordings.size() - 1,
          learned ? "; learn the rooms again with roomwise rooms learn" : ""),
      {{"home", home.file()},
       {"forgotten", name},
       {"walks", recordings.size() - 1},
       {"keyframes", left.size()}}};
}

}  // namespace

void add_forget_command(CLI::App& app, Context& context) {
  const auto [command, options] = add_command<ForgetOptions>(
      app, context, "forget",
      "Take a walk out of a home, with its pictures and what was learned of rooms; the other walks "
      "stay",
      "roomwise forget sunday_walk --home my.home", forget);
  command->add_option("WALK", options.walk, "Name of the walk, as roomwise info lists it")
      ->required();
  command->add_option("--home", options.home, "Home file")->required();
}

}  // namespace roomwise::app
