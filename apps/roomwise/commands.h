#pragma once

#include "command.h"

// Every command of the program, one file each.
namespace roomwise::app {

void add_accounts_commands(CLI::App& app, Context& context);
void add_help_command(CLI::App& app, Context& context);
void add_info_command(CLI::App& app, Context& context);
void add_check_command(CLI::App& app, Context& context);
void add_backup_commands(CLI::App& app, Context& context);
void add_record_command(CLI::App& app, Context& context);
void add_optimize_command(CLI::App& app, Context& context);
void add_concepts_commands(CLI::App& app, Context& context);
void add_objects_commands(CLI::App& app, Context& context);
void add_edit_commands(CLI::App& app, Context& context);
void add_eval_commands(CLI::App& app, Context& context);
void add_locate_command(CLI::App& app, Context& context);
void add_device_command(CLI::App& app, Context& context);
void add_export_commands(CLI::App& app, Context& context);
void add_contents_exports(CLI::App& group, Context& context);  // of "export"
void add_laboratory_commands(CLI::App& app, Context& context);
void add_laboratory_evaluations(CLI::App& group, Context& context);  // of "eval"
void add_map_command(CLI::App& app, Context& context);
void add_forget_command(CLI::App& app, Context& context);
void add_cull_command(CLI::App& app, Context& context);
void add_rooms_commands(CLI::App& app, Context& context);
void add_layout_command(CLI::App& group, Context& context);         // of "rooms"
void add_coverage_command(CLI::App& group, Context& context);       // likewise
void add_room_objects_commands(CLI::App& group, Context& context);  // likewise
void add_networks_commands(CLI::App& app, Context& context);
void add_networks_looks(CLI::App& group, Context& context);     // of "networks"
void add_networks_quantize(CLI::App& group, Context& context);  // likewise
void add_protect_command(CLI::App& app, Context& context);
void add_report_command(CLI::App& app, Context& context);
void add_serve_command(CLI::App& app, Context& context);
void add_things_commands(CLI::App& app, Context& context);
void add_spots_commands(CLI::App& app, Context& context);
void add_update_command(CLI::App& app, Context& context);

}  // namespace roomwise::app
