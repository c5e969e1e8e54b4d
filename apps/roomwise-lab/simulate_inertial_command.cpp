#include <filesystem>

#include "commands.h"
#include "laboratory/simulation/walk/inertial_sensor.h"
#include "roomwise/recording/inertial_file.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

struct SimulateInertialOptions {
  fs::path recording;
  simulation::InertialSensorOptions sensor;
};

Expected<Answer> run(const SimulateInertialOptions& options, Context& context) {
  simulation::InertialSensorOptions sensor = options.sensor;
  sensor.seed = context.seed;
  ROOMWISE_RETURN_IF_ERROR(sensor.validate());
  const fs::path file = options.recording / "imu.txt";
  std::error_code ignored;
  if (fs::exists(file, ignored)) {
    return fail("{}: exists already; remove it to make another", file.string());
  }
  ROOMWISE_TRY(const auto truth, recording::read_trajectory(options.recording / "groundtruth.txt"));
  const geometry::InertialTrack track = simulation::simulate_inertial_sensor(truth, sensor);
  if (track.empty()) return fail("{}: groundtruth.txt holds one pose", options.recording.string());
  ROOMWISE_RETURN_IF_ERROR(recording::write_inertial(
      options.recording, track,
      fmt::format("made of groundtruth.txt: a phone's inertial sensor, seed {}", sensor.seed)));
  return Answer{fmt::format("wrote {}: {} samples\n", file.string(), track.samples().size()),
                {{"output", file.string()}, {"samples", track.samples().size()}}};
}

}  // namespace

void add_simulate_inertial_command(CLI::App& app, Context& context) {
  const auto [command, options] = add_command<SimulateInertialOptions>(
      app, context, "simulate-inertial",
      "Give a recording with truth what an inertial sensor would have felt (imu.txt)",
      "roomwise simulate-inertial walk --seed 7", run);
  command->add_option("RECORDING", options.recording, "Folder with groundtruth.txt, whose z is up")
      ->required();
  add_setting(*command, "--rate", options.sensor.rate_hz, "Samples a second",
              CLI::Range(1.0, 10'000.0));
}

}  // namespace roomwise::app
