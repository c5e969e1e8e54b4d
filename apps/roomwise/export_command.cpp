#include <filesystem>
#include <memory>

#include "command_run.h"
#include "commands.h"
#include "open_home.h"
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
  std::string surface = "cloud";
  double voxel_size_m = 0.02;
  double cell_m = 0.05;
  fusion::FloorGridOptions floor;
};

Answer wrote(const fs::path& output, const std::string& what, std::size_t count) {
  Answer answer;
  answer.text = fmt::format("wrote {} {} to {}\n", count, what, output.string());
  answer.json = {{what, count}, {"output", output.string()}};
  return answer;
}

Expected<pipeline::MapCloud> build_cloud(const ExportOptions& options, Context& context) {
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  CommandRun run(context);
  ROOMWISE_TRY(pipeline::MapCloud map, pipeline::build_map_cloud(home, options.voxel_size_m, run));
  if (map.cloud.size() == 0) {
    return fail("{}: the home has no map yet; make one with roomwise map", home.file());
  }
  return map;
}

Expected<pipeline::GravityAlignedMap> build_surface(const ExportOptions& options, Context& context,
                                                    ThreadPool& pool) {
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  StageClock clock;
  pipeline::RunContext run{pool, context.progress, clock};
  return pipeline::build_gravity_aligned_map(home, options.voxel_size_m, run);
}

Answer wrote_mesh(const fs::path& output, const pipeline::GravityAlignedMap& map) {
  const fusion::TriangleMesh& mesh = map.mesh_world;
  Answer answer;
  answer.text = fmt::format("wrote {} vertices, {} triangles to {}\n", mesh.vertices.size(),
                            mesh.triangles.size(), output.string());
  answer.json = {{"vertices", mesh.vertices.size()},
                 {"triangles", mesh.triangles.size()},
                 {"output", output.string()}};
  return answer;
}

// Where the gravity-aligned frame of a file lies in the map's world, that of the other files.
void add_frame(Answer& answer, const fusion::GravityAlignedFrame& frame) {
  const geometry::RigidTransform& pose = frame.gravity_from_world;
  const auto& [t, q] = std::pair(pose.translation, pose.rotation);
  answer.json["level_from_world"] = {{"translation_m", {t.x(), t.y(), t.z()}},
                                     {"quaternion_xyzw", {q.x(), q.y(), q.z(), q.w()}}};
  answer.json["floor_found"] = frame.has_floor;
  if (!frame.has_floor) {
    answer.text += "the map shows no floor: z = 0 is the height of the first camera\n";
  }
}

Expected<Answer> export_ply(const ExportOptions& options, Context& context) {
  if (options.surface == "mesh") {
    ThreadPool pool(context.threads);
    ROOMWISE_TRY(const pipeline::GravityAlignedMap map, build_surface(options, context, pool));
    ROOMWISE_CHECK_OK(fusion::write_ply(options.output, map.mesh_world));
    return wrote_mesh(options.output, map);
  }
  ROOMWISE_TRY(const pipeline::MapCloud map, build_cloud(options, context));
  ROOMWISE_CHECK_OK(mapping::write_ply(options.output, map.cloud));
  return wrote(options.output, "points", map.cloud.size());
}

Expected<Answer> export_pcd(const ExportOptions& options, Context& context) {
  ROOMWISE_TRY(const pipeline::MapCloud map, build_cloud(options, context));
  ROOMWISE_CHECK_OK(mapping::write_pcd(options.output, map.cloud));
  return wrote(options.output, "points", map.cloud.size());
}

Expected<Answer> export_glb(const ExportOptions& options, Context& context) {
  ThreadPool pool(context.threads);
  ROOMWISE_TRY(const pipeline::GravityAlignedMap map, build_surface(options, context, pool));
  ROOMWISE_CHECK_OK(fusion::write_glb(
      options.output, fusion::transformed(map.frame.gravity_from_world, map.mesh_world)));
  Answer answer = wrote_mesh(options.output, map);
  add_frame(answer, map.frame);
  return answer;
}

Expected<Answer> export_octomap(const ExportOptions& options, Context& context) {
  ROOMWISE_CHECK_OK(pipeline::validate_cell(options.cell_m, options.voxel_size_m));
  ThreadPool pool(context.threads);
  ROOMWISE_TRY(const pipeline::GravityAlignedMap map, build_surface(options, context, pool));
  StageClock clock;
  pipeline::RunContext run{pool, context.progress, clock};
  ROOMWISE_TRY(const auto cells, pipeline::occupancy_of(map, options.cell_m, run));
  ROOMWISE_CHECK_OK(fusion::write_octomap(options.output, cells, options.cell_m));
  const auto occupied = std::ranges::count(cells, true, &fusion::OccupancyCell::is_occupied);
  Answer answer;
  answer.text = fmt::format("wrote {} occupied and {} free cells to {}\n", occupied,
                            std::ssize(cells) - occupied, options.output.string());
  answer.json = {{"occupied", occupied},
                 {"free", std::ssize(cells) - occupied},
                 {"output", options.output.string()}};
  add_frame(answer, map.frame);
  return answer;
}

Expected<Answer> export_floor(const ExportOptions& options, Context& context) {
  fusion::FloorGridOptions floor = options.floor;
  floor.cell_m = options.cell_m;
  ROOMWISE_CHECK_OK(floor.validate());
  ROOMWISE_CHECK_OK(pipeline::validate_cell(options.cell_m, options.voxel_size_m));
  ThreadPool pool(context.threads);
  ROOMWISE_TRY(const pipeline::GravityAlignedMap map, build_surface(options, context, pool));
  StageClock clock;
  pipeline::RunContext run{pool, context.progress, clock};
  auto grid = pipeline::floor_grid_of(map, floor, run);
  if (!grid) return Unexpected(std::move(grid).error().in(options.home.string()));
  ROOMWISE_CHECK_OK(fusion::write_floor_map(options.output, *grid));
  const fs::path picture = fusion::floor_map_picture(options.output);
  const double free_m2 = grid->area_m2(fusion::FloorCell::kFree);
  const double occupied_m2 = grid->area_m2(fusion::FloorCell::kOccupied);
  Answer answer;
  answer.text = fmt::format("wrote {:.1f} m2 of free floor, {:.1f} m2 occupied, to {} and {}\n",
                            free_m2, occupied_m2, options.output.string(), picture.string());
  answer.json = {
      {"free_m2", free_m2},   {"occupied_m2", occupied_m2},        {"columns", grid->columns()},
      {"rows", grid->rows()}, {"output", options.output.string()}, {"picture", picture.string()}};
  add_frame(answer, map.frame);
  return answer;
}

Expected<Answer> export_tum(const ExportOptions& options, const Context& context) {
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  ROOMWISE_TRY(const recording::Trajectory trajectory, pipeline::stored_trajectory(home));
  ROOMWISE_CHECK_OK(recording::write_trajectory(options.output, trajectory));
  return wrote(options.output, "poses", trajectory.size());
}

// Without the loops that the map left out. Pieces that no loop joined are parts of the one graph
// without an edge between them.
Expected<Answer> export_g2o(const ExportOptions& options, const Context& context) {
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  ROOMWISE_TRY(const auto settings, pipeline::stored_map_settings(home));
  ROOMWISE_TRY(
      const mapping::PoseGraph graph,
      pipeline::stored_pose_graph(home, settings ? settings->solver : mapping::MapSolverOptions{}));
  ROOMWISE_CHECK_OK(mapping::write_g2o(options.output, graph));
  return wrote(options.output, "poses", graph.world_from_node.size());
}

void add_files(CLI::App& command, ExportOptions& options) {
  command.add_option("--home", options.home, "Home file")->required();
  command.add_option("-o,--output", options.output, "File to write")->required();
}

void add_voxel(CLI::App& command, ExportOptions& options, const std::string& meaning) {
  command.add_option("--voxel", options.voxel_size_m, meaning)
      ->check(positive())
      ->capture_default_str();
}

constexpr const char* kFusedVoxel =
    "Size of the voxels that the key-frames are fused in, m; half the size takes 8 times the "
    "memory";

void add_cell(CLI::App& command, ExportOptions& options) {
  command.add_option("--cell", options.cell_m, "Size of a cell, m")
      ->check(positive())
      ->capture_default_str();
}

std::string demand_yaml(const std::string& path) {
  return fs::path(path).extension() == ".yaml" ? "" : path + ": must end in .yaml";
}

void add_cloud_exports(CLI::App& group, Context& context,
                       const std::shared_ptr<ExportOptions>& options) {
  CLI::App* ply =
      add_command(group, context, "ply", "The map as coloured points or as a surface (PLY)",
                  "roomwise export ply --home my.home -o my.ply --voxel 0.01",
                  [options, &context] { return export_ply(*options, context); });
  add_files(*ply, *options);
  ply->add_option("--surface", options->surface,
                  "cloud: one point a voxel; mesh: triangles of the fused key-frames")
      ->check(CLI::IsMember({"cloud", "mesh"}))
      ->capture_default_str();
  add_voxel(*ply, *options, "Size of the voxels, m");

  CLI::App* pcd = add_command(group, context, "pcd", "The map as coloured points (PCD)",
                              "roomwise export pcd --home my.home -o my.pcd",
                              [options, &context] { return export_pcd(*options, context); });
  add_files(*pcd, *options);
  add_voxel(*pcd, *options, "One point a voxel of this size, m");
}

void add_level_exports(CLI::App& group, Context& context,
                       const std::shared_ptr<ExportOptions>& options) {
  CLI::App* glb =
      add_command(group, context, "glb", "The map's surface, upright, in one file (binary glTF)",
                  "roomwise export glb --home my.home -o my.glb",
                  [options, &context] { return export_glb(*options, context); });
  add_files(*glb, *options);
  add_voxel(*glb, *options, kFusedVoxel);

  CLI::App* octomap = add_command(
      group, context, "octomap", "What of space is occupied and what is free (OctoMap, binary .bt)",
      "roomwise export octomap --home my.home -o my.bt",
      [options, &context] { return export_octomap(*options, context); });
  add_files(*octomap, *options);
  add_voxel(*octomap, *options, kFusedVoxel);
  add_cell(*octomap, *options);

  CLI::App* floor = add_command(
      group, context, "floor",
      "Where the floor is free for a person (a map for ROS: .yaml, and a picture beside it)",
      "roomwise export floor --home my.home -o my.yaml",
      [options, &context] { return export_floor(*options, context); });
  add_files(*floor, *options);
  floor->get_option("--output")->check(CLI::Validator(demand_yaml, ""));
  add_voxel(*floor, *options, kFusedVoxel);
  add_cell(*floor, *options);
  floor
      ->add_option("--height", options->floor.person_height_m,
                   "What hangs higher than that is in nobody's way, m")
      ->check(positive())
      ->capture_default_str();
  floor->add_option("--step", options->floor.step_m, "What lies lower than that is no obstacle, m")
      ->check(positive())
      ->capture_default_str();
}

}  // namespace

void add_export_commands(CLI::App& app, Context& context) {
  CLI::App* group =
      add_group(app, "export", "Write what a home holds in formats that other programs read",
                "roomwise export ply --home my.home -o my.ply");
  auto options = std::make_shared<ExportOptions>();
  add_cloud_exports(*group, context, options);
  add_level_exports(*group, context, options);

  CLI::App* tum = add_command(*group, context, "tum",
                              "The pose of every frame (TUM: timestamp tx ty tz qx qy qz qw)",
                              "roomwise export tum --home my.home -o trajectory.txt",
                              [options, &context] { return export_tum(*options, context); });
  add_files(*tum, *options);

  CLI::App* g2o = add_command(*group, context, "g2o", "The pose graph of the key-frames (.g2o)",
                              "roomwise export g2o --home my.home -o my.g2o",
                              [options, &context] { return export_g2o(*options, context); });
  add_files(*g2o, *options);
}

}  // namespace roomwise::app
