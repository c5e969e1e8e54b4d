// The exports that tell what stands in a home and where its walks led, and never overwrite.

#include <filesystem>

#include "command_run.h"
#include "commands.h"
#include "open_home.h"
#include "roomwise/base/file.h"
#include "roomwise/pipeline/exports/home_json.h"
#include "roomwise/pipeline/exports/indoor_gml.h"
#include "roomwise/pipeline/exports/picture_dataset.h"
#include "roomwise/pipeline/exports/scene_graph_json.h"
#include "roomwise/pipeline/exports/walk_mcap.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

struct ContentsOptions {
  fs::path home;
  fs::path output;
};

struct PicturesOptions {
  fs::path home;
  fs::path output;
  std::string walk;
  pipeline::DatasetOptions dataset;
  std::string language = "en";  // of mcap
};

// Asked before long work.
Expected<void> check_is_new(const fs::path& output) {
  std::error_code ignored;
  if (fs::is_regular_file(output, ignored) || fs::is_directory(output, ignored)) {
    return fail("{}: is there and is not overwritten; choose another name", output.string());
  }
  return check_can_write(output);
}

// What no export can place, in words.
std::string left_apart(const pipeline::HomeContents& contents) {
  std::string text;
  if (const std::size_t count = contents.keyframes_apart(); count > 0) {
    text += fmt::format(
        "{} key-frames and {} things lie in pieces of the map that no loop joined to the largest: "
        "they have no place in it\n",
        count, contents.things_apart());
  }
  if (!contents.floor.frame.has_floor) {
    text += "the map shows no floor: z = 0 is the height of the first camera\n";
  }
  if (contents.rooms.empty()) {
    text += "no rooms are named; name them with roomwise rooms name\n";
  } else if (!contents.layout) {
    text += "the map does not show where the rooms lie: they have no polygons\n";
  }
  return text;
}

Answer wrote_contents(const fs::path& output, const pipeline::HomeContents& contents) {
  Answer answer{fmt::format("wrote {} rooms, {} things, {} walks to {}\n", contents.rooms.size(),
                            contents.things.size(), contents.walks.size(), output.string()),
                {{"rooms", contents.rooms.size()},
                 {"things", contents.things.size()},
                 {"walks", contents.walks.size()},
                 {"keyframes_elsewhere", contents.keyframes_apart()},
                 {"things_elsewhere", contents.things_apart()},
                 {"floor_found", contents.floor.frame.has_floor},
                 {"rooms_placed", contents.layout.has_value()},
                 {"output", output.string()}}};
  answer.text += left_apart(contents);
  return answer;
}

Expected<Answer> export_contents(const ContentsOptions& options, Context& context,
                                 std::string (*write)(const pipeline::HomeContents&)) {
  ROOMWISE_RETURN_IF_ERROR(check_is_new(options.output));
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  CommandRun run(context);
  ROOMWISE_TRY(const pipeline::HomeContents contents, pipeline::read_home_contents(home, run));
  ROOMWISE_RETURN_IF_ERROR(write_file(options.output, write(contents)));
  return wrote_contents(options.output, contents);
}

Expected<Answer> export_json(const ContentsOptions& options, Context& context) {
  return export_contents(options, context, pipeline::home_json);
}

using WriteDataset = Expected<pipeline::PictureDataset> (*)(const home::Home&, const fs::path&,
                                                            const pipeline::DatasetOptions&,
                                                            pipeline::RunContext&);

Expected<Answer> export_pictures(const PicturesOptions& options, Context& context,
                                 WriteDataset write) {
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  pipeline::DatasetOptions dataset = options.dataset;
  if (!options.walk.empty()) {
    ROOMWISE_TRY(dataset.walk, find_walk(home, options.walk));
  }
  CommandRun run(context);
  ROOMWISE_TRY(const pipeline::PictureDataset wrote, write(home, options.output, dataset, run));
  Answer answer{
      fmt::format("wrote {} pictures of {} walks and {} points to {}\n", wrote.views.size(),
                  wrote.walks.size(), wrote.points.size(), options.output.string()),
      {{"pictures", wrote.views.size()},
       {"walks", wrote.walks.size()},
       {"points", wrote.points.size()},
       {"keyframes_elsewhere", wrote.keyframes_apart},
       {"output", options.output.string()}}};
  if (wrote.keyframes_apart > 0) {
    answer.text += fmt::format(
        "{} key-frames lie in pieces of the map that no loop joined to the largest: they are left "
        "out\n",
        wrote.keyframes_apart);
  }
  if (wrote.points.empty()) answer.text += "no picture has depth: there are no points\n";
  return answer;
}

Expected<Answer> export_colmap(const PicturesOptions& options, Context& context) {
  return export_pictures(options, context, pipeline::write_colmap);
}

Expected<Answer> export_nerfstudio(const PicturesOptions& options, Context& context) {
  return export_pictures(options, context, pipeline::write_nerfstudio);
}

void add_pictures(CLI::App& group, Context& context, const std::string& name,
                  const std::string& description, const std::string& example,
                  Expected<Answer> (*body)(const PicturesOptions&, Context&)) {
  const auto [command, options] = add_command<PicturesOptions>(group, context, name, description,
                                                               "roomwise export " + example, body);
  command->add_option("--home", options.home, "Home file")->required();
  command->add_option("-o,--output", options.output, "New folder to write")->required();
  command->add_option("--walk", options.walk, "Of this walk alone; default: of all");
  add_setting(*command, "--voxel", options.dataset.voxel_size_m,
              "One point at most a voxel of this size, m", positive());
}

Expected<Answer> export_scene_graph(const ContentsOptions& options, Context& context) {
  return export_contents(options, context, pipeline::scene_graph_json);
}

// What of a home its plan leaves out, in words.
std::string left_out(const pipeline::IndoorPlan& plan, const pipeline::HomeContents& contents) {
  std::string text = left_apart(contents);
  if (plan.rooms_without_place > 0) {
    text += fmt::format("{} rooms have no floor on the map: they are left out\n",
                        plan.rooms_without_place);
  }
  if (plan.stairs_without_rooms > 0) {
    text += fmt::format(
        "{} flights of stairs do not lead from one named room to another: they are left out\n",
        plan.stairs_without_rooms);
  }
  return text;
}

Expected<Answer> export_indoorgml(const ContentsOptions& options, Context& context) {
  ROOMWISE_RETURN_IF_ERROR(check_is_new(options.output));
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  CommandRun run(context);
  ROOMWISE_TRY(const pipeline::HomeContents contents, pipeline::read_home_contents(home, run));
  auto plan = pipeline::indoor_gml(contents);
  if (!plan) return Unexpected(std::move(plan.error()).with_context(home.file()));
  ROOMWISE_RETURN_IF_ERROR(write_file(options.output, plan->gml));
  return Answer{
      fmt::format(
          "wrote {} rooms, {} doors, {} openings, {} flights of stairs, {} things to {}\n{}",
          plan->rooms, plan->doors, plan->openings, plan->stairs, plan->things,
          options.output.string(), left_out(*plan, contents)),
      {{"rooms", plan->rooms},
       {"doors", plan->doors},
       {"openings", plan->openings},
       {"stairs", plan->stairs},
       {"things", plan->things},
       {"rooms_elsewhere", plan->rooms_without_place},
       {"stairs_elsewhere", plan->stairs_without_rooms},
       {"things_elsewhere", contents.things_apart()},
       {"output", options.output.string()}}};
}

Expected<Answer> export_mcap(const PicturesOptions& options, Context& context) {
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  ROOMWISE_TRY(const home::RecordingId walk, find_walk(home, options.walk));
  CommandRun run(context);
  ROOMWISE_TRY(const pipeline::WalkLog log,
               pipeline::write_walk_mcap(home, walk, options.output,
                                         {options.dataset.voxel_size_m, options.language}, run));
  Answer answer{fmt::format("wrote {} poses, {} pictures, {} points, {} things, {} rooms, {} "
                            "prompts to {}\n",
                            log.poses, log.pictures, log.points, log.things, log.rooms, log.prompts,
                            options.output.string()),
                {{"poses", log.poses},
                 {"pictures", log.pictures},
                 {"points", log.points},
                 {"things", log.things},
                 {"rooms", log.rooms},
                 {"prompts", log.prompts},
                 {"keyframes_elsewhere", log.keyframes_apart},
                 {"output", options.output.string()}}};
  if (log.keyframes_apart > 0) {
    answer.text += fmt::format(
        "{} key-frames of the walk lie in pieces of the map that no loop joined to the largest: "
        "they are left out\n",
        log.keyframes_apart);
  }
  return answer;
}

void add_mcap(CLI::App& group, Context& context) {
  const auto [command, options] =
      add_command<PicturesOptions>(group, context, "mcap",
                                   "A walk to play back in Foxglove: poses, pictures, camera, the "
                                   "map's points, boxes of things, "
                                   "outlines of rooms, what is said on entering them (MCAP, JSON)",
                                   "roomwise export mcap --home my.home -o my.mcap", export_mcap);
  command->add_option("--home", options.home, "Home file")->required();
  command->add_option("-o,--output", options.output, "New file to write")->required();
  command->add_option("--walk", options.walk, "Which walk; default: the newest");
  add_setting(*command, "--voxel", options.dataset.voxel_size_m,
              "One point of the map a voxel of this size, m", positive());
  add_setting(*command, "--language", options.language, "Of what is said: en, de, es or fr");
}

void add_contents(CLI::App& group, Context& context, const std::string& name,
                  const std::string& description, const std::string& example,
                  Expected<Answer> (*body)(const ContentsOptions&, Context&)) {
  const auto [command, options] = add_command<ContentsOptions>(group, context, name, description,
                                                               "roomwise export " + example, body);
  command->add_option("--home", options.home, "Home file")->required();
  command->add_option("-o,--output", options.output, "New file to write")->required();
}

}  // namespace

void add_contents_exports(CLI::App& group, Context& context) {
  add_contents(group, context, "json",
               "Rooms as polygons, doors, things with their boxes, walks: plain JSON "
               "(docs/home.schema.json)",
               "json --home my.home -o my.json", export_json);
  add_pictures(group, context, "colmap",
               "Pictures of the key-frames with cameras, poses and points (COLMAP's text model)",
               "colmap --home my.home -o my-colmap", export_colmap);
  add_pictures(group, context, "nerfstudio",
               "Pictures and depth of the key-frames with cameras and poses (Nerfstudio's "
               "transforms.json)",
               "nerfstudio --home my.home -o my-scene", export_nerfstudio);
  add_contents(
      group, context, "scene-graph",
      "Building, rooms, things and what joins them, as a 3-D scene graph (Spark-DSG's JSON)",
      "scene-graph --home my.home -o my-graph.json", export_scene_graph);
  add_contents(
      group, context, "indoorgml",
      "The plan: rooms by storey, doors and stairs between them, things (IndoorGML 1.0.3, in "
      "the home's own metres)",
      "indoorgml --home my.home -o my.gml", export_indoorgml);
  add_mcap(group, context);
}

}  // namespace roomwise::app
