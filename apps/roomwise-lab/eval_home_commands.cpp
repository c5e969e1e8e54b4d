#include <filesystem>
#include <functional>
#include <numbers>
#include <set>

#include "command_run.h"
#include "commands.h"
#include "figures.h"
#include "laboratory/trials/object_report.h"
#include "laboratory/trials/truth_evaluation.h"
#include "open_home.h"
#include "reliability_json.h"
#include "render_options.h"
#include "roomwise/base/file.h"
#include "roomwise/pipeline/rooms/home_layout.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

struct HomeEvaluationOptions {
  fs::path home;
  fs::path truth;
  fs::path recording;
  double max_distance_m = 1.0;
  std::string surface = "cloud";
  trials::MapEvaluationOptions map;
  fs::path furniture = kFurnitureFolder;
  fs::path report;
};

Json to_json(const evaluation::ObjectCounts& counts) {
  return {{"found", counts.matched},
          {"missed", counts.missed},
          {"beyond", counts.beyond},
          {"double", counts.duplicates},
          {"false", counts.wrong}};
}

Json to_json(const trials::FoundObjectErrors& result) {
  const evaluation::ObjectErrors& errors = result.errors;
  Json json = to_json(errors.all);
  json["without_place"] = result.without_place;
  const auto of_matches = [&](double figure) {
    return errors.matches.empty() ? Json(nullptr) : Json(figure);
  };
  json["from_surface_m"] = {{"median", of_matches(errors.from_box_quantile_m(0.5))},
                            {"p90", of_matches(errors.from_box_quantile_m(0.9))}};
  json["from_middle_m"] = {{"median", of_matches(errors.from_center_quantile_m(0.5))},
                           {"p90", of_matches(errors.from_center_quantile_m(0.9))}};
  json["objects"] = Json::object();
  for (const auto& [kind, counts] : errors.by_kind) json["objects"][kind] = to_json(counts);
  return json;
}

std::string row_of(
    const std::string& name, const trials::ObjectEvaluation& result,
    const std::function<evaluation::ObjectCounts(const trials::FoundObjectErrors&)>& counts_of) {
  std::string row = fmt::format("{:<16}", name);
  for (const auto* way : {&result.instances, &result.naive, &result.by_rules}) {
    const evaluation::ObjectCounts counts = counts_of(*way);
    row += fmt::format(" | {:>5} {:>6} {:>6} {:>6} {:>5}", counts.matched, counts.missed,
                       counts.beyond, counts.duplicates, counts.wrong);
  }
  return row + "\n";
}

std::string distances_of(const char* way, const trials::FoundObjectErrors& result) {
  const evaluation::ObjectErrors& errors = result.errors;
  std::string text;
  if (!errors.matches.empty()) {
    text = fmt::format(
        "{}: from the thing's middle median {:.2f} m, 90 % within {:.2f} m; from its surface "
        "{:.2f} "
        "m, {:.2f} m\n",
        way, errors.from_center_quantile_m(0.5), errors.from_center_quantile_m(0.9),
        errors.from_box_quantile_m(0.5), errors.from_box_quantile_m(0.9));
  }
  if (result.without_place > 0) {
    text += fmt::format("{}: found without a place {}\n", way, result.without_place);
  }
  return text;
}

Json json_of(const evaluation::Proportion& share) {
  return share.n == 0 ? Json(nullptr) : Json(share.value());
}

// Everything about each pair and each thing that is left over.
Json details_of(const trials::ObjectEvaluation& result, const trials::FoundObjectErrors& way) {
  Json json = Json::array();
  for (const evaluation::ObjectMatch& match : way.errors.matches) {
    json.push_back({{"found", way.found[match.found].kind},
                    {"truth", result.truth[match.truth].kind},
                    {"from_middle_m", match.from_center_m},
                    {"from_surface_m", match.from_box_m}});
  }
  return json;
}

Expected<Answer> evaluate_objects(const HomeEvaluationOptions& options, Context& context) {
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  ROOMWISE_TRY(
      const trials::ObjectEvaluation result,
      trials::evaluate_objects(home, {options.truth, options.recording}, options.max_distance_m));
  const char* columns = "found missed beyond double false";
  Answer answer;
  answer.text = fmt::format("{:<16} | {:<32} | {:<32} | {}\n{:<16} | {} | {} | {}\n", "",
                            "joined from regions", "naive clustering", "the paper's rules",
                            "object", columns, columns, columns);
  std::set<std::string> kinds;
  for (const auto* way : {&result.instances, &result.naive, &result.by_rules}) {
    for (const auto& [kind, counts] : way->errors.by_kind) kinds.insert(kind);
  }
  for (const std::string& kind : kinds) {
    answer.text += row_of(kind, result, [&](const trials::FoundObjectErrors& way) {
      const auto found = way.errors.by_kind.find(kind);
      return found == way.errors.by_kind.end() ? evaluation::ObjectCounts{} : found->second;
    });
  }
  answer.text +=
      row_of("all", result, [](const trials::FoundObjectErrors& way) { return way.errors.all; });
  answer.text += distances_of("joined from regions", result.instances) +
                 distances_of("naive clustering", result.naive) +
                 distances_of("the paper's rules", result.by_rules);
  if (!result.instances.errors.matches.empty()) {
    answer.text += fmt::format(
        "middles within one standard deviation: {:.0f} %, within two: {:.0f} % (of a "
        "normal error 68 %, 95 %)\n",
        100 * result.coverage.one_sigma.value(), 100 * result.coverage.two_sigma.value());
  }
  answer.json = {{"instances", to_json(result.instances)},
                 {"naive", to_json(result.naive)},
                 {"rules", to_json(result.by_rules)},
                 {"ours", to_json(result.instances.errors.all)},
                 {"paper", to_json(result.by_rules.errors.all)}};
  answer.json["instances"]["within_one_sigma"] = json_of(result.coverage.one_sigma);
  answer.json["instances"]["within_two_sigma"] = json_of(result.coverage.two_sigma);
  answer.json["instances"]["reliability"] = reliability_json(result.forecasts);
  answer.json["instances"]["pairs"] = details_of(result, result.instances);
  answer.json["naive"]["pairs"] = details_of(result, result.naive);
  answer.json["rules"]["pairs"] = details_of(result, result.by_rules);
  if (!options.report.empty()) {
    ROOMWISE_TRY(const evaluation::ObjectReportContent content,
                 trials::object_report(home, options.home.stem().string(), result));
    ROOMWISE_RETURN_IF_ERROR(write_file(options.report, render_object_report(content)));
  }
  return answer;
}

Expected<Answer> evaluate_map(const HomeEvaluationOptions& options, Context& context) {
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  CommandRun run(context);
  trials::MapEvaluationOptions map = options.map;
  if (options.surface == "mesh") map.surface = trials::MapSurface::kMesh;
  ROOMWISE_TRY(const evaluation::CloudError error,
               trials::evaluate_map(home, options.truth, options.furniture, map, run));
  const double far = static_cast<double>(error.far_points) / static_cast<double>(error.points);
  return Answer{
      fmt::format(
          "{} points\n"
          "from the surface: median {:.4f} m, RMSE {:.4f} m\n"
          "within 1 cm {:.1f} %, within 5 cm {:.1f} %, nothing within half a metre {:.2f} %\n",
          error.points, error.distance_m.median, error.distance_m.rmse, 100 * error.within_1cm,
          100 * error.within_5cm, 100 * far),
      {{"points", error.points},
       {"median_m", error.distance_m.median},
       {"rmse_m", error.distance_m.rmse},
       {"within_1cm", error.within_1cm},
       {"within_5cm", error.within_5cm},
       {"far", far}}};
}

Expected<Answer> evaluate_floor(const HomeEvaluationOptions& options, Context& context) {
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  CommandRun run(context);
  ROOMWISE_TRY(const trials::FloorEvaluation result,
               trials::evaluate_floor(home, options.truth, run));
  const evaluation::FloorError& error = result.error;
  const double tilt_deg = result.tilt_rad * 180 / std::numbers::pi;
  return Answer{
      fmt::format(
          "where a person may stand: {:.1f} m2 in truth, {:.1f} m2 by the map, {:.1f} m2 by both\n"
          "precision {:.3f}, recall {:.3f}; a cell aside counted as right: {:.3f}, {:.3f}\n"
          "the floor lies {:+.3f} m above the true one, tilted by {:.2f} degrees\n",
          error.true_m2, error.found_m2, error.both_m2, error.precision, error.recall,
          error.precision_within_cell, error.recall_within_cell, result.floor_above_truth_m,
          tilt_deg),
      {{"true_m2", error.true_m2},
       {"found_m2", error.found_m2},
       {"both_m2", error.both_m2},
       {"precision", error.precision},
       {"recall", error.recall},
       {"precision_within_cell", error.precision_within_cell},
       {"recall_within_cell", error.recall_within_cell},
       {"floor_above_truth_m", result.floor_above_truth_m},
       {"tilt_deg", tilt_deg}}};
}

void add_stairs(const trials::LayoutEvaluation& result, Answer& answer) {
  answer.text += fmt::format(
      "storeys: {} of {}; stairs: {} found, {} true; {:.2f} m2 called free where one would fall\n",
      result.found_storeys, result.storeys, result.found_stairs, result.stairs.size(),
      result.open_floor_m2);
  Json stairs = Json::array();
  for (const trials::StairsError& one : result.stairs) {
    answer.text += one.is_found ? fmt::format(
                                      "stairs of {} steps: {} counted, foot {:.2f} m off, top "
                                      "{:.2f} m, width {:+.2f} m, "
                                      "heading {:.1f} degrees; rails {}\n",
                                      one.steps, one.found_steps, one.foot_m, one.top_m,
                                      one.width_m, one.heading_rad * 180 / std::numbers::pi,
                                      one.are_rails_right ? "right" : "wrong")
                                : fmt::format("stairs of {} steps: not found\n", one.steps);
    const auto of_found = [&](double figure) {
      return one.is_found ? Json(figure) : Json(nullptr);
    };
    stairs.push_back({{"found", one.is_found},
                      {"steps", one.steps},
                      {"found_steps", one.found_steps},
                      {"foot_error_m", of_found(one.foot_m)},
                      {"top_error_m", of_found(one.top_m)},
                      {"width_error_m", of_found(one.width_m)},
                      {"heading_error_rad", of_found(one.heading_rad)},
                      {"rails_right", one.are_rails_right}});
  }
  answer.json["storeys"] = result.storeys;
  answer.json["found_storeys"] = result.found_storeys;
  answer.json["found_stairs"] = result.found_stairs;
  answer.json["stairs"] = std::move(stairs);
  answer.json["open_floor_m2"] = result.open_floor_m2;
}

Expected<Answer> evaluate_layout(const HomeEvaluationOptions& options, Context& context) {
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  CommandRun run(context);
  ROOMWISE_TRY(const trials::LayoutEvaluation result,
               trials::evaluate_layout(home, options.truth, run));
  const std::optional<double> door_m = quantile_of(result.door_errors_m, 0.5);
  Answer answer{
      fmt::format("floor: {:.1f} m2 in rooms, {:.1f} m2 of it given to the right one\n"
                  "doors: {} of {} found, median {} m off; {} doorways where no door is\n"
                  "things: {} of {} lie in their room\n",
                  result.floor_m2, result.right_floor_m2, result.found_doors, result.doors,
                  text_or_none(door_m), result.false_doorways, result.right_things, result.things),
      {{"floor_m2", result.floor_m2},
       {"right_floor_m2", result.right_floor_m2},
       {"doors", result.doors},
       {"found_doors", result.found_doors},
       {"false_doorways", result.false_doorways},
       {"door_error_median_m", json_or_null(door_m)},
       {"things", result.things},
       {"right_things", result.right_things}}};
  if (result.storeys > 1 || result.found_storeys > 1) add_stairs(result, answer);
  return answer;
}

// A command that measures a home against the recording that it was mapped from.
std::pair<CLI::App*, HomeEvaluationOptions&> add_evaluation(
    CLI::App& group, Context& context, const std::string& name, const std::string& description,
    const std::string& more_example,
    Expected<Answer> (*body)(const HomeEvaluationOptions&, Context&),
    const std::string& truth = "Simulated recording") {
  const auto [command, options] = add_command<HomeEvaluationOptions>(
      group, context, name, description,
      "roomwise eval " + name + " --home flat.home --truth flat" + more_example, body);
  command->add_option("--home", options.home, "Home mapped from the recording")->required();
  command->add_option("--truth", options.truth, truth)->required();
  return {command, options};
}

}  // namespace

void add_home_evaluations(CLI::App& group, Context& context) {
  const auto [objects, of_objects] = add_evaluation(
      group, context, "objects",
      "The objects of a home, both ways and by naive clustering, against the truth of a recording, "
      "simulated or labelled by people: found and missed of what it shows well, found beyond that, "
      "found twice, false, and how far from where they are",
      " --report objects.html\n"
      "roomwise eval objects --home office.home --truth tests/truth/office_walk.objects.json",
      evaluate_objects, "Simulated recording, or the file of what people labelled in a real one");
  objects
      ->add_option("--recording", of_objects.recording,
                   "Real recording that the home was mapped from; default: where it was then")
      ->check(CLI::ExistingDirectory);
  add_setting(*objects, "--max-distance", of_objects.max_distance_m,
              "Maximum distance of a found thing from the true one, m", positive());
  objects->add_option("--report", of_objects.report,
                      "Write a page of HTML with all tables, and pictures of what is false, missed "
                      "and found");
  const auto [map, of_map] = add_evaluation(
      group, context, "map",
      "The points of a map, or its fused surface, against the surfaces of a simulated home", "",
      evaluate_map);
  add_setting(*map, "--surface", of_map.surface,
              "cloud: averaged points; mesh: vertices of the fused surface",
              CLI::IsMember({"cloud", "mesh"}));
  add_setting(*map, "--voxel", of_map.map.voxel_size_m, "Size of the voxels, m", positive());
  map->add_flag("--true-poses", of_map.map.at_true_poses,
                "Put the key-frames where they were in truth");
  add_furniture_option(*map, of_map.furniture);
  add_evaluation(
      group, context, "floor",
      "Where a map says that a person may stand against the free space of a simulated home", "",
      evaluate_floor);
  add_evaluation(
      group, context, "layout",
      "Where a home's rooms end and where its doors are against the plan of a simulated home", "",
      evaluate_layout);
}

}  // namespace roomwise::app
