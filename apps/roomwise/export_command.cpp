#include <filesystem>
#include <memory>

#include "commands.h"
#include "roomwise/home/home.h"
#include "roomwise/mapping/g2o_file.h"
#include "roomwise/mapping/map_solver.h"
#include "roomwise/mapping/ply_file.h"
#include "roomwise/pipeline/map_cloud.h"
#include "roomwise/pipeline/map_settings.h"
#include "roomwise/pipeline/stored_map.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

struct Options {
  fs::path home;
  fs::path output;
  double voxel_size_m = 0.02;
};

Answer wrote(const fs::path& output, const std::string& what, std::size_t count) {
  Answer answer;
  answer.text = fmt::format("wrote {} {} to {}\n", count, what, output.string());
  answer.json = {{what, count}, {"output", output.string()}};
  return answer;
}

Expected<Answer> export_ply(const Options& options, Context& context) {
  ROOMWISE_TRY(const home::Home home, home::Home::open_read_only(options.home));
  ThreadPool pool(context.threads);
  StageClock clock;
  pipeline::RunContext run{pool, context.progress, clock};
  ROOMWISE_TRY(const pipeline::MapCloud map,
               pipeline::build_map_cloud(home, options.voxel_size_m, run));
  ROOMWISE_CHECK_OK(mapping::write_ply(options.output, map.cloud));
  return wrote(options.output, "points", map.cloud.size());
}

Expected<Answer> export_tum(const Options& options) {
  ROOMWISE_TRY(const home::Home home, home::Home::open_read_only(options.home));
  ROOMWISE_TRY(const recording::Trajectory trajectory, pipeline::stored_trajectory(home));
  ROOMWISE_CHECK_OK(recording::write_trajectory(options.output, trajectory));
  return wrote(options.output, "poses", trajectory.size());
}

// Without the loops that the map left out. Pieces that no loop joined are parts of the one graph
// without an edge between them.
Expected<Answer> export_g2o(const Options& options) {
  ROOMWISE_TRY(const home::Home home, home::Home::open_read_only(options.home));
  ROOMWISE_TRY(const auto settings, pipeline::stored_map_settings(home));
  ROOMWISE_TRY(
      const mapping::PoseGraph graph,
      pipeline::stored_pose_graph(home, settings ? settings->solver : mapping::MapSolverOptions{}));
  ROOMWISE_CHECK_OK(mapping::write_g2o(options.output, graph));
  return wrote(options.output, "poses", graph.world_from_node.size());
}

void add_files(CLI::App& command, Options& options) {
  command.add_option("--home", options.home, "Home file")->required();
  command.add_option("-o,--output", options.output, "File to write")->required();
}

}  // namespace

void add_export_commands(CLI::App& app, Context& context) {
  CLI::App* group =
      add_group(app, "export", "Write what a home holds in formats that other programs read",
                "roomwise export ply --home my.home -o my.ply");
  auto options = std::make_shared<Options>();

  CLI::App* ply = add_command(*group, context, "ply", "The map as a coloured point cloud (PLY)",
                              "roomwise export ply --home my.home -o my.ply --voxel 0.01",
                              [options, &context] { return export_ply(*options, context); });
  add_files(*ply, *options);
  ply->add_option("--voxel", options->voxel_size_m, "One point a voxel of this size, m")
      ->check(positive())
      ->capture_default_str();

  CLI::App* tum = add_command(*group, context, "tum",
                              "The pose of every frame (TUM: timestamp tx ty tz qx qy qz qw)",
                              "roomwise export tum --home my.home -o trajectory.txt",
                              [options] { return export_tum(*options); });
  add_files(*tum, *options);

  CLI::App* g2o = add_command(*group, context, "g2o", "The pose graph of the key-frames (.g2o)",
                              "roomwise export g2o --home my.home -o my.g2o",
                              [options] { return export_g2o(*options); });
  add_files(*g2o, *options);
}

}  // namespace roomwise::app
