#include "commands.h"
#include "own_kinds.h"

int main(int argc, char** argv) {
  using namespace roomwise::app;

  CLI::App app("Turns RGB-D recordings of a home into a map with rooms and objects.", "roomwise");
  app.set_version_flag("--version", ROOMWISE_VERSION);
  app.require_subcommand(1);
  app.footer(
      "Example:\n"
      "  roomwise map RECORDING --home my.home\n"
      "Every command explains itself: roomwise COMMAND --help");

  Context context;
  context.prepare = add_own_kinds;

  add_info_command(app, context);
  add_check_command(app, context);
  add_backup_commands(app, context);
  add_record_command(app, context);
  add_map_command(app, context);
  add_forget_command(app, context);
  add_cull_command(app, context);
  add_locate_command(app, context);
  add_things_commands(app, context);
  add_spots_commands(app, context);
  add_update_command(app, context);
  add_rooms_commands(app, context);
  add_optimize_command(app, context);
  add_concepts_commands(app, context);
  add_objects_commands(app, context);
  add_edit_commands(app, context);
  add_eval_commands(app, context);
  add_export_commands(app, context);
  add_report_command(app, context);
  add_serve_command(app, context);
  add_accounts_commands(app, context);
  add_device_command(app, context);
  add_protect_command(app, context);
  add_networks_commands(app, context);
  add_laboratory_commands(app, context);
  add_help_command(app, context);
  return run(app, context, argc, argv);
}
