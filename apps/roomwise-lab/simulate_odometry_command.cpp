#include <filesystem>

#include "commands.h"
#include "laboratory/simulation/walk/odometry.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

struct SimulateOdometryOptions {
  fs::path recording;
  simulation::OdometryOptions odometry;
};

Expected<Answer> run(const SimulateOdometryOptions& options, Context& context) {
  simulation::OdometryOptions odometry = options.odometry;
  odometry.seed = context.seed;
  ROOMWISE_RETURN_IF_ERROR(odometry.validate());
  const fs::path file = options.recording / "odometry.txt";
  std::error_code ignored;
  if (fs::exists(file, ignored)) {
    return fail("{}: exists already; remove it to make another", file.string());
  }
  ROOMWISE_TRY(const auto truth, recording::read_trajectory(options.recording / "groundtruth.txt"));
  const recording::Odometry simulated = simulation::simulate_odometry(truth, odometry);
  ROOMWISE_RETURN_IF_ERROR(recording::write_odometry(
      file, simulated,
      fmt::format("made of groundtruth.txt: drift {}, {} jumps, {} dropouts, seed {}",
                  odometry.drift, odometry.jumps, odometry.dropouts, odometry.seed)));
  return Answer{fmt::format("wrote {}: {} poses\n", file.string(), simulated.poses.size()),
                {{"output", file.string()}, {"poses", simulated.poses.size()}}};
}

}  // namespace

void add_simulate_odometry_command(CLI::App& app, Context& context) {
  const auto [command, options] = add_command<SimulateOdometryOptions>(
      app, context, "simulate-odometry",
      "Give a recording with truth what a device's own odometry would have said (odometry.txt)",
      "roomwise simulate-odometry walk --drift 0.01 --jumps 2", run);
  command->add_option("RECORDING", options.recording, "Folder with groundtruth.txt")->required();
  add_setting(*command, "--drift", options.odometry.drift, "Drift, part of the way",
              CLI::Range(0.0, 0.5));
  add_setting(*command, "--jumps", options.odometry.jumps, "How often it finds itself elsewhere",
              not_negative());
  add_setting(*command, "--dropouts", options.odometry.dropouts,
              "How often it says nothing for 1 to 2 s", not_negative());
}

}  // namespace roomwise::app
