#include <filesystem>

#include "commands.h"
#include "laboratory_program.h"
#include "own_kinds.h"

int main(int argc, char** argv) {
  using namespace roomwise::app;

  // "roomwise simulate" becomes this program, and goes on by its name.
  CLI::App app("Makes up homes, and measures what Roomwise makes of them against the truth.",
               std::filesystem::path(argv[0]).filename().string());
  app.set_version_flag("--version", ROOMWISE_VERSION);
  app.require_subcommand(1);
  app.footer(
      "Example:\n"
      "  roomwise-lab simulate -o flat\n"
      "Every command explains itself: roomwise-lab COMMAND --help");

  Context context;
  context.prepare = add_own_kinds;

  add_simulate_command(app, context);
  add_simulate_inertial_command(app, context);
  add_simulate_odometry_command(app, context);
  add_simulate_views_command(app, context);
  add_fit_instances_command(app, context);
  add_fit_localizer_command(app, context);
  add_fit_rooms_command(app, context);
  add_guidance_command(app, context);
  add_label_command(app, context);
  add_lift_labels_command(app, context);
  add_own_things_command(app, context);
  add_paper_command(app, context);
  add_study_commands(app, context);
  add_command_elsewhere(app, context, "train",
                        "Fine-tune a network on pictures of your own classes", kTraining);
  CLI::App* group = add_group(app, "eval", "Measure results against the truth",
                              "roomwise-lab eval objects --home flat.home --truth flat");
  add_home_evaluations(*group, context);
  add_localizer_evaluation(*group, context);
  add_changes_evaluation(*group, context);
  return run(app, context, argc, argv);
}
