// The commands of the laboratory, by the names that they have there.
#include "commands.h"
#include "laboratory_program.h"

namespace roomwise::app {

void add_laboratory_commands(CLI::App& app, Context& context) {
  add_command_elsewhere(app, context, "simulate",
                        "Record a walk through a made-up, furnished home, with its truth",
                        kLaboratory);
  add_command_elsewhere(app, context, "simulate-inertial",
                        "Give a recording with truth what an inertial sensor would have felt",
                        kLaboratory);
  add_command_elsewhere(app, context, "simulate-odometry",
                        "Give a recording with truth what a device's own odometry would have said",
                        kLaboratory);
  add_command_elsewhere(app, context, "simulate-views",
                        "Take pictures of made-up homes to train by, one folder a class",
                        kLaboratory);
  add_command_elsewhere(app, context, "train",
                        "Fine-tune a network on pictures of your own classes", kTraining);
}

void add_laboratory_evaluations(CLI::App& group, Context& context) {
  const auto add = [&](const char* name, const char* description) {
    add_command_elsewhere(group, context, name, description, kLaboratory);
  };
  add("objects", "The objects of a home against the truth of a simulated recording");
  add("map", "The points or the surface of a map against the surfaces of a simulated home");
  add("floor", "Where a person may stand against the free space of a simulated home");
  add("layout", "Where rooms end and doors are against the plan of a simulated home");
  add("localizer", "The frames of another walk, localised and compared with the truth");
  add("changes", "What update would say of a later simulated walk against the truth");
}

}  // namespace roomwise::app
