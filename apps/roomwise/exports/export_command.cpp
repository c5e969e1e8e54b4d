#include <filesystem>

#include "command_run.h"
#include "commands.h"
#include "open_home.h"
#include "pose_json.h"
#include "roomwise/base/in_context.h"
#include "roomwise/fusion/floor_map_file.h"
#include "roomwise/fusion/mesh_files.h"
#include "roomwise/fusion/octomap_file.h"
#include "roomwise/home/home.h"
#include "roomwise/mapping/backend/map_solver.h"
#include "roomwise/mapping/cloud/pcd_file.h"
#include "roomwise/mapping/cloud/ply_file.h"
#include "roomwise/mapping/graph/g2o_file.h"
#include "roomwise/pipeline/mapping/gravity_aligned_map.h"
#include "roomwise/pipeline/mapping/map_cloud.h"
#include "roomwise/pipeline/stored/map_settings.h"
#include "roomwise/pipeline/stored/stored_map.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

struct ExportOptions {
  fs::path home;
  fs::path output;
  std::string walk;
  std::string surface = "cloud";
  double voxel_size_m = 0.02;
  double cell_m = 0.05;
  fusion::FloorGridOptions floor;
};

Answer wrote(const fs::path& output, const std::string& what, std::size_t count) {
  return Answer{fmt::format("wrote {} {} to {}\n", count, what, output.string()),
                {{what, count}, {"output", output.string()}}};
}

Expected<pipeline::MapCloud> build_cloud(const ExportOptions& options, Context& context) {
  // Finer than depth is measured; in so small voxels a home's points are too many to be told apart.
  constexpr double kFinest_m = 0.001, kCoarsest_m = 1;
  if (!(options.voxel_size_m >= kFinest_m && options.voxel_size_m <= kCoarsest_m)) {
    return fail("--voxel must be {} to {} m, not {}", kFinest_m, kCoarsest_m, options.voxel_size_m);
  }
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  CommandRun run(context);
  ROOMWISE_TRY(pipeline::MapCloud map, pipeline::build_map_cloud(home, options.voxel_size_m, run));
  if (map.cloud.size() == 0) {
    return fail("{}: the home has no map yet; make one with roomwise map", home.file());
  }
  return map;
}

Expected<pipeline::GravityAlignedMap> build_surface(const ExportOptions& options, Context& context,
                                                    pipeline::RunContext& run) {
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  return pipeline::build_gravity_aligned_map(home, {.voxel_size_m = options.voxel_size_m}, run);
}

Answer wrote_mesh(const fs::path& output, const pipeline::GravityAlignedMap& map) {
  const fusion::PiecewiseMesh& mesh = map.mesh_world;
  return Answer{fmt::format("wrote {} vertices, {} triangles to {}\n", mesh.vertex_count(),
                            mesh.triangle_count(), output.string()),
                {{"vertices", mesh.vertex_count()},
                 {"triangles", mesh.triangle_count()},
                 {"output", output.string()}}};
}

// Where the gravity-aligned frame of a file lies in the map's world, that of the other files.
void add_frame(Answer& answer, const fusion::GravityAlignedFrame& frame) {
  answer.json["level_from_world"] = level_from_world_json(frame.gravity_from_world);
  answer.json["floor_found"] = frame.has_floor;
  if (!frame.has_floor) {
    answer.text += "the map shows no floor: z = 0 is the height of the first camera\n";
  }
}

Expected<Answer> export_ply(const ExportOptions& options, Context& context) {
  if (options.surface == "mesh") {
    CommandRun run(context);
    ROOMWISE_TRY(const pipeline::GravityAlignedMap map, build_surface(options, context, run));
    ROOMWISE_RETURN_IF_ERROR(fusion::write_ply(options.output, map.mesh_world));
    return wrote_mesh(options.output, map);
  }
  ROOMWISE_TRY(const pipeline::MapCloud map, build_cloud(options, context));
  ROOMWISE_RETURN_IF_ERROR(mapping::write_ply(options.output, map.cloud));
  return wrote(options.output, "points", map.cloud.size());
}

Expected<Answer> export_pcd(const ExportOptions& options, Context& context) {
  ROOMWISE_TRY(const pipeline::MapCloud map, build_cloud(options, context));
  ROOMWISE_RETURN_IF_ERROR(mapping::write_pcd(options.output, map.cloud));
  return wrote(options.output, "points", map.cloud.size());
}

Expected<Answer> export_glb(const ExportOptions& options, Context& context) {
  CommandRun run(context);
  ROOMWISE_TRY(const pipeline::GravityAlignedMap map, build_surface(options, context, run));
  ROOMWISE_RETURN_IF_ERROR(fusion::write_glb(
      options.output, fusion::transformed(map.frame.gravity_from_world, map.mesh_world)));
  Answer answer = wrote_mesh(options.output, map);
  add_frame(answer, map.frame);
  return answer;
}

Expected<Answer> export_octomap(const ExportOptions& options, Context& context) {
  ROOMWISE_RETURN_IF_ERROR(pipeline::validate_cell(options.cell_m, options.voxel_size_m));
  CommandRun run(context);
  ROOMWISE_TRY(pipeline::GravityAlignedMap map, build_surface(options, context, run));
  ROOMWISE_TRY(const auto cells, pipeline::occupancy_of(map, options.cell_m, run));
  ROOMWISE_RETURN_IF_ERROR(fusion::write_octomap(options.output, cells, options.cell_m));
  const auto occupied = std::ranges::count(cells, true, &fusion::OccupancyCell::is_occupied);
  Answer answer{fmt::format("wrote {} occupied and {} free cells to {}\n", occupied,
                            std::ssize(cells) - occupied, options.output.string()),
                {{"occupied", occupied},
                 {"free", std::ssize(cells) - occupied},
                 {"output", options.output.string()}}};
  add_frame(answer, map.frame);
  return answer;
}

// my.yaml, my-storey-2.yaml, ...: the lowest storey has the name that was given.
fs::path map_of_storey(const fs::path& output, std::size_t storey) {
  if (storey == 0) return output;
  fs::path path = output;
  return path.replace_filename(
      fmt::format("{}-storey-{}.yaml", output.stem().string(), storey + 1));
}

Expected<Answer> export_floor(const ExportOptions& options, Context& context) {
  fusion::FloorGridOptions floor = options.floor;
  floor.cell_m = options.cell_m;
  ROOMWISE_RETURN_IF_ERROR(floor.validate());
  ROOMWISE_RETURN_IF_ERROR(pipeline::validate_cell(options.cell_m, options.voxel_size_m));
  CommandRun run(context);
  ROOMWISE_TRY(pipeline::GravityAlignedMap map, build_surface(options, context, run));
  ROOMWISE_TRY(const auto grids,
               in_context(options.home.string(), pipeline::floor_grids_of(map, floor, run)));
  std::string text;
  Json storeys = Json::array();
  for (std::size_t i = 0; i < grids.size(); ++i) {
    const fusion::FloorGrid& grid = grids[i];
    const fs::path output = map_of_storey(options.output, i);
    ROOMWISE_RETURN_IF_ERROR(fusion::write_floor_map(output, grid));
    const fs::path picture = fusion::floor_map_picture(output);
    const double free_m2 = grid.area_m2(fusion::FloorCell::kFree);
    const double occupied_m2 = grid.area_m2(fusion::FloorCell::kOccupied);
    text += fmt::format("wrote {:.1f} m2 of free floor, {:.1f} m2 occupied, to {} and {}\n",
                        free_m2, occupied_m2, output.string(), picture.string());
    storeys.push_back({{"free_m2", free_m2},
                       {"occupied_m2", occupied_m2},
                       {"columns", grid.columns()},
                       {"rows", grid.rows()},
                       {"output", output.string()},
                       {"picture", picture.string()}});
  }
  Answer answer{std::move(text), storeys.front()};
  if (grids.size() > 1) {
    for (std::size_t i = 0; i < storeys.size(); ++i) {
      storeys[i]["floor_m"] = map.frame.storeys.floor_m(i);
    }
    answer.json["storeys"] = std::move(storeys);
  }
  add_frame(answer, map.frame);
  return answer;
}

Expected<Answer> export_tum(const ExportOptions& options, Context& context) {
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  std::optional<home::RecordingId> walk;
  if (!options.walk.empty()) {
    ROOMWISE_TRY(walk, find_walk(home, options.walk));
  }
  ROOMWISE_TRY(const recording::Trajectory trajectory, pipeline::stored_trajectory(home, walk));
  ROOMWISE_RETURN_IF_ERROR(recording::write_trajectory(options.output, trajectory));
  return wrote(options.output, "poses", trajectory.size());
}

// Without the loops that the map left out. Components that no loop joined are parts of the one
// graph without an edge between them.
Expected<Answer> export_g2o(const ExportOptions& options, Context& context) {
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  ROOMWISE_TRY(const auto settings, pipeline::stored_map_settings(home));
  ROOMWISE_TRY(
      const mapping::PoseGraph graph,
      pipeline::stored_pose_graph(home, settings ? settings->solver : mapping::MapSolverOptions{}));
  ROOMWISE_RETURN_IF_ERROR(mapping::write_g2o(options.output, graph));
  return wrote(options.output, "poses", graph.world_from_node.size());
}

// A command that writes what a home holds to a file.
std::pair<CLI::App*, ExportOptions&> add_export(
    CLI::App& group, Context& context, const std::string& name, const std::string& description,
    const std::string& example, Expected<Answer> (*body)(const ExportOptions&, Context&)) {
  const auto [command, options] = add_command<ExportOptions>(group, context, name, description,
                                                             "roomwise export " + example, body);
  command->add_option("--home", options.home, "Home file")->required();
  command->add_option("-o,--output", options.output, "File to write")->required();
  return {command, options};
}

void add_voxel(CLI::App& command, ExportOptions& options, const std::string& meaning) {
  add_setting(command, "--voxel", options.voxel_size_m, meaning, positive());
}

void add_fused_voxel(CLI::App& command, ExportOptions& options) {
  add_voxel(
      command, options,
      "Size of the voxels that the key-frames are fused in, m; half the size makes 8 times as "
      "many");
}

void add_cell(CLI::App& command, ExportOptions& options) {
  add_setting(command, "--cell", options.cell_m, "Size of a cell, m", positive());
}

std::string demand_yaml(const std::string& path) {
  return fs::path(path).extension() == ".yaml" ? "" : path + ": must end in .yaml";
}

void add_floor_export(CLI::App& group, Context& context) {
  const auto [command, options] = add_export(
      group, context, "floor",
      "Where the floor is free for a person (a map for ROS: .yaml, and a picture beside it)",
      "floor --home my.home -o my.yaml", export_floor);
  command->get_option("--output")->check(CLI::Validator(demand_yaml, ""));
  add_fused_voxel(*command, options);
  add_cell(*command, options);
  add_setting(*command, "--height", options.floor.person_height_m,
              "Height of a person: what hangs higher is not an obstacle, m", positive());
  add_setting(*command, "--step", options.floor.step_m,
              "Height of a step: what lies lower is not an obstacle, m", positive());
}

}  // namespace

void add_export_commands(CLI::App& app, Context& context) {
  CLI::App* group =
      add_group(app, "export", "Write what a home holds in formats that other programs read",
                "roomwise export ply --home my.home -o my.ply");
  const auto [ply, of_ply] =
      add_export(*group, context, "ply", "The map as coloured points or as a surface (PLY)",
                 "ply --home my.home -o my.ply --voxel 0.01", export_ply);
  add_setting(*ply, "--surface", of_ply.surface,
              "cloud: one point a voxel; mesh: triangles of the fused key-frames",
              CLI::IsMember({"cloud", "mesh"}));
  add_voxel(*ply, of_ply, "Size of the voxels, m");
  const auto [pcd, of_pcd] = add_export(*group, context, "pcd", "The map as coloured points (PCD)",
                                        "pcd --home my.home -o my.pcd", export_pcd);
  add_voxel(*pcd, of_pcd, "One point a voxel of this size, m");
  const auto [glb, of_glb] =
      add_export(*group, context, "glb", "The map's surface, upright, in one file (binary glTF)",
                 "glb --home my.home -o my.glb", export_glb);
  add_fused_voxel(*glb, of_glb);
  const auto [octomap, of_octomap] =
      add_export(*group, context, "octomap",
                 "What of space is occupied and what is free (OctoMap, binary .bt)",
                 "octomap --home my.home -o my.bt", export_octomap);
  add_fused_voxel(*octomap, of_octomap);
  add_cell(*octomap, of_octomap);
  add_floor_export(*group, context);
  {
    const auto [command, options] = add_export(
        *group, context, "tum", "The pose of every frame (TUM: timestamp tx ty tz qx qy qz qw)",
        "tum --home my.home -o trajectory.txt", export_tum);
    command->add_option("--walk", options.walk,
                        "Of this walk alone; default: of all, one after the other");
  }
  add_export(*group, context, "g2o", "The pose graph of the key-frames (.g2o)",
             "g2o --home my.home -o my.g2o", export_g2o);
  add_contents_exports(*group, context);
}

}  // namespace roomwise::app
