#include <algorithm>
#include <array>
#include <filesystem>

#include "camera_option.h"
#include "command_run.h"
#include "commands.h"
#include "laboratory/simulation/home/home_geometry.h"
#include "laboratory/simulation/recording/recording_folder.h"
#include "laboratory/simulation/recording/simulate_recording.h"
#include "render_options.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;
using simulation::SensorOptions;
using simulation::SimulationOptions;

struct SimulateOptions {
  std::optional<std::uint64_t> home_seed;
  std::vector<std::string> rooms;
  int storeys = 1;
  std::optional<std::uint64_t> furniture_seed, finish_seed;
  bool mirrored = false;
  std::string scenario = "day";
  std::optional<std::uint64_t> scenario_seed, walk_seed;
  std::string camera;
  std::vector<std::string> without;
  fs::path furniture = kFurnitureFolder;
  fs::path output;
  bool keep = false;
  SimulationOptions simulation;
};

// What of the sensor can be switched off by name.
constexpr std::array<std::pair<std::string_view, bool SensorOptions::*>, 12> kEffects{{
    {"auto-exposure", &SensorOptions::auto_exposure},
    {"exposure-errors", &SensorOptions::exposure_errors},
    {"auto-white-balance", &SensorOptions::auto_white_balance},
    {"white-balance-errors", &SensorOptions::white_balance_errors},
    {"motion-blur", &SensorOptions::motion_blur},
    {"color-noise", &SensorOptions::color_noise},
    {"depth-noise", &SensorOptions::depth_noise},
    {"depth-quantization", &SensorOptions::depth_quantization},
    {"projector-shadow", &SensorOptions::projector_shadow},
    {"lost-surfaces", &SensorOptions::lost_surfaces},
    {"edge-jitter", &SensorOptions::edge_jitter},
    {"limited-range", &SensorOptions::limited_range},
}};
constexpr std::array kDepthEffects{
    &SensorOptions::depth_noise,      &SensorOptions::depth_quantization,
    &SensorOptions::projector_shadow, &SensorOptions::lost_surfaces,
    &SensorOptions::edge_jitter,      &SensorOptions::limited_range};

std::string effect_names() {
  std::string names;
  for (const auto& [name, member] : kEffects)
    names += (names.empty() ? "" : ", ") + std::string(name);
  return names;
}

Expected<void> switch_off(const std::vector<std::string>& effects, SensorOptions& sensor) {
  for (const std::string& effect : effects) {
    if (effect == "depth-effects") {
      for (const auto member : kDepthEffects) sensor.*member = false;
      continue;
    }
    const auto found = std::ranges::find(kEffects, effect, [](const auto& e) { return e.first; });
    if (found == kEffects.end()) {
      return fail("'{}' is nothing that a sensor does; there are depth-effects, {}", effect,
                  effect_names());
    }
    sensor.*found->second = false;
  }
  return {};
}

Expected<SimulationOptions> complete(const SimulateOptions& options, std::uint64_t seed) {
  SimulationOptions simulated = options.simulation;
  if (options.home_seed || !options.rooms.empty() || options.storeys != 1) {
    simulation::HomeOptions home{options.home_seed.value_or(seed),
                                 {},
                                 options.storeys,
                                 options.furniture_seed,
                                 options.finish_seed,
                                 options.mirrored};
    for (const std::string& room : options.rooms) {
      ROOMWISE_TRY(const simulation::RoomKind kind, simulation::parse_room_kind(room));
      home.rooms.push_back(kind);
    }
    simulated.home = std::move(home);
  }
  ROOMWISE_TRY(simulated.scenario, simulation::parse_scenario(options.scenario));
  simulated.scenario_seed = options.scenario_seed.value_or(seed);
  simulated.walk.seed = options.walk_seed.value_or(seed);
  simulated.sensor.seed = simulated.walk.seed;
  ROOMWISE_RETURN_IF_ERROR(switch_off(options.without, simulated.sensor));
  // A fixed exposure is right where an automatic one needs no amplification.
  constexpr double kMidGrey = 0.18;
  simulated.sensor.exposure = kMidGrey / simulated.sensor.unamplified_radiance;
  ROOMWISE_TRY(const auto camera, given_camera(options.camera));
  if (camera) simulated.camera = *camera;
  return simulated;
}

Expected<Answer> run(const SimulateOptions& options, Context& context) {
  ROOMWISE_TRY(const SimulationOptions simulated, complete(options, context.seed));
  ROOMWISE_TRY(const auto catalogue, simulation::FurnitureCatalogue::open(options.furniture));
  if (options.keep) {
    ROOMWISE_TRY(const bool is_made,
                 simulation::is_made_already(options.output, simulated, catalogue));
    if (is_made) {
      return Answer{fmt::format("{} is there already\n", options.output.string()),
                    {{"output", options.output.string()}, {"kept", true}}};
    }
  }
  ThreadPool pool(context.threads);
  StageClock clock;
  ROOMWISE_TRY(
      const simulation::SimulationSummary summary,
      simulate_recording(simulated, catalogue, options.output, pool, context.progress, clock));
  if (!summary.finished) {
    return fail_with(
        ErrorCode::kInterrupted,
        "interrupted after {} frames; {} holds them, and the same command begins it anew",
        summary.frames, options.output.string());
  }
  Answer answer{
      fmt::format(
          "rooms    {}\n"
          "objects  {}\n"
          "light    {}\n"
          "frames   {}, a walk of {:.0f} s\n"
          "wrote {}; the furniture's makers are named in its credits.txt\n",
          summary.rooms, summary.objects,
          summary.bake.from_cache
              ? "as baked before"
              : fmt::format("baked in {:.1f} s of processor time, {:.1f} million rays",
                            summary.bake.cpu_s, static_cast<double>(summary.bake.rays) / 1e6),
          summary.frames, summary.seconds, options.output.string()),
      {{"frames", summary.frames},
       {"seconds", summary.seconds},
       {"rooms", summary.rooms},
       {"objects", summary.objects},
       {"bake",
        {{"from_cache", summary.bake.from_cache},
         {"cpu_s", summary.bake.cpu_s},
         {"rays", summary.bake.rays}}},
       {"output", options.output.string()}}};
  add_stages(answer, clock);
  answer.json["cpu_s"] = process_cpu_time_s();
  return answer;
}

}  // namespace

void add_simulate_command(CLI::App& app, Context& context) {
  const auto [command, options] = add_command<SimulateOptions>(
      app, context, "simulate",
      "Record a walk through a made-up home, with the truth about everything in it",
      "roomwise simulate --home-seed 7 --scenario evening -o walk", run);
  SimulationOptions& simulated = options.simulation;
  command->add_option("-o,--output", options.output, "Folder to write; new or empty")->required();
  command
      ->add_option("--home-seed", options.home_seed,
                   "Which home; default: the reference flat (bedroom, kitchen, toilet, hall)")
      ->check(not_negative());
  command
      ->add_option("--rooms", options.rooms,
                   "The home's rooms, separated by commas: bedroom, kitchen, toilet, living-room, "
                   "dining-room, hall, study; default: 3 to 8 by the seed")
      ->delimiter(',');
  add_setting(*command, "--storeys", options.storeys, "1, or 2 with a staircase between them",
              CLI::Range(1, 2));
  const auto twin = [&](CLI::Option* option) { option->needs(command->get_option("--home-seed")); };
  twin(command
           ->add_option("--furniture-seed", options.furniture_seed,
                        "Another home of the same plan: what stands and hangs in it; default: "
                        "--home-seed")
           ->check(not_negative()));
  twin(command
           ->add_option("--finish-seed", options.finish_seed,
                        "Likewise: what floors, walls and ceilings are covered with; default: "
                        "--home-seed")
           ->check(not_negative()));
  twin(command->add_flag("--mirrored", options.mirrored,
                         "Likewise: with left and right exchanged, as the flat across the "
                         "stairwell"));
  command->add_flag("--bare-halls", simulated.bare_halls,
                    "Nothing stands or hangs in halls, and all there is painted plainly");
  add_setting(*command, "--scenario", options.scenario,
              "day, evening, night, moved or moved-night");
  command->add_option("--scenario-seed", options.scenario_seed, "What is moved; default: --seed")
      ->check(not_negative());
  command->add_option("--walk-seed", options.walk_seed, "Which walk; default: --seed")
      ->check(not_negative());
  command->add_option("--frames", simulated.walk.max_frames, "Maximum number of frames")
      ->check(positive());
  add_setting(*command, "--fps", simulated.walk.frames_per_second, "Frames a second", positive());
  add_setting(*command, "--height", simulated.walk.camera_height_m, "Height of the camera, m",
              positive());
  add_setting(*command, "--turning", simulated.walk.max_turning_rad_s,
              "Maximum turning speed of the walker, rad/s", positive());
  command->add_flag("!--no-fast-turns", simulated.walk.fast_turns,
                    "Without the few turns that are faster than that");
  add_camera_option(*command, options.camera, "640x480, no distortion");
  add_render_options(*command, simulated.render, options.furniture);
  command
      ->add_option("--without", options.without,
                   "What the sensor does not do, separated by commas: depth-effects (all of "
                   "depth's; depth is then exact), " +
                       effect_names())
      ->delimiter(',');
  command->add_option("--light-cache", simulated.render.light_cache,
                      "File that keeps the home's baked light for the next walk through it");
  command->add_flag("--keep", options.keep,
                    "Do nothing where the folder holds this very recording already");
}

}  // namespace roomwise::app
