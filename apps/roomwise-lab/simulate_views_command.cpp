#include "commands.h"
#include "laboratory/simulation/home/home_geometry.h"
#include "laboratory/simulation/recording/simulate_views.h"
#include "render_options.h"
#include "roomwise/base/stage_clock.h"

namespace roomwise::app {
namespace {

struct SimulateViewsOptions {
  std::vector<std::string> rooms;
  std::filesystem::path furniture = kFurnitureFolder;
  std::filesystem::path output;
  simulation::ViewsOptions views;
};

Expected<Answer> run(const SimulateViewsOptions& options, Context& context) {
  simulation::ViewsOptions views = options.views;
  views.seed = context.seed;
  for (const std::string& room : options.rooms) {
    ROOMWISE_TRY(const simulation::RoomKind kind, simulation::parse_room_kind(room));
    views.rooms.push_back(kind);
  }
  ROOMWISE_TRY(const auto catalogue, simulation::FurnitureCatalogue::open(options.furniture));
  ThreadPool pool(context.threads);
  ROOMWISE_TRY(const simulation::ViewsSummary summary,
               simulate_views(views, catalogue, options.output, pool, context.progress));
  if (!summary.finished) {
    return fail_with(ErrorCode::kInterrupted,
                     "interrupted after {} homes; the same command goes on", summary.homes);
  }
  return Answer{
      fmt::format("{} pictures of {} homes in {}; the furniture's makers are named in its "
                  "credits.txt\n",
                  summary.pictures, summary.homes, options.output.string()),
      {{"pictures", summary.pictures},
       {"homes", summary.homes},
       {"output", options.output.string()},
       {"cpu_s", process_cpu_time_s()}}};
}

}  // namespace

void add_simulate_views_command(CLI::App& app, Context& context) {
  const auto [command, options] = add_command<SimulateViewsOptions>(
      app, context, "simulate-views",
      "Take pictures of the furniture and rooms of made-up homes, a folder a class, to train by",
      "roomwise simulate-views --homes 101 300 -o views\n"
      "roomwise train views --network compact --out trained\n"
      "Each home is seen at one time of day, drawn by the seed. After an interruption the same\n"
      "command goes on.",
      run);
  simulation::ViewsOptions& views = options.views;
  command->add_option("-o,--output", options.output, "Folder to write; new, empty or begun")
      ->required();
  command
      ->add_option_function<std::pair<std::uint64_t, std::uint64_t>>(
          "--homes",
          [&options = options](const auto& range) {
            std::tie(options.views.first_home, options.views.last_home) = range;
          },
          "Seeds of the homes: first and last; default: 1 10")
      ->type_name("FIRST LAST");
  command
      ->add_option("--rooms", options.rooms,
                   "Every home's rooms, separated by commas; default: 3 to 8 by its seed")
      ->delimiter(',');
  add_setting(*command, "--of-kind", views.views.of_kind,
              "Maximum number of pictures of each kind of furniture in a home");
  add_setting(*command, "--of-room", views.views.of_room,
              "Maximum number of pictures of each room");
  add_setting(*command, "--side", views.views.longer_side_px,
              "Longer side of the pictures, pixels");
  add_render_options(*command, views.render, options.furniture);
}

}  // namespace roomwise::app
