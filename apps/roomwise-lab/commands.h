#pragma once

#include "command.h"

// Every command of the laboratory, one file each.
namespace roomwise::app {

void add_home_evaluations(CLI::App& group, Context& context);      // of "eval"
void add_localizer_evaluation(CLI::App& group, Context& context);  // of "eval"
void add_changes_evaluation(CLI::App& group, Context& context);    // of "eval"
void add_fit_instances_command(CLI::App& app, Context& context);
void add_fit_localizer_command(CLI::App& app, Context& context);
void add_fit_rooms_command(CLI::App& app, Context& context);
void add_guidance_command(CLI::App& app, Context& context);
void add_label_command(CLI::App& app, Context& context);
void add_lift_labels_command(CLI::App& app, Context& context);
void add_own_things_command(CLI::App& app, Context& context);
void add_paper_command(CLI::App& app, Context& context);
void add_study_commands(CLI::App& app, Context& context);  // study, study-task, study-table
void add_simulate_command(CLI::App& app, Context& context);
void add_simulate_inertial_command(CLI::App& app, Context& context);
void add_simulate_odometry_command(CLI::App& app, Context& context);
void add_simulate_views_command(CLI::App& app, Context& context);

}  // namespace roomwise::app
