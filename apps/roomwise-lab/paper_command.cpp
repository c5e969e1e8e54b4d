#include <fmt/ranges.h>

#include <cmath>
#include <filesystem>

#include "commands.h"
#include "laboratory/studies/paper_page.h"
#include "laboratory/studies/paper_study.h"
#include "networks.h"
#include "roomwise/base/file.h"
#include "this_program.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;
using studies::PaperPart;
using studies::PaperResults;

struct PaperOptions {
  studies::PaperStudyOptions study;
  std::vector<std::string> only;
  fs::path output;
};

Json to_json(const studies::MappingRow& row) {
  Json json{{"recording", row.data.name},
            {"simulated", row.data.is_simulated},
            {"method", row.method},
            {"features", row.features}};
  for (const studies::MappingTrial& trial : row.trials) {
    json["trials"].push_back({{"frames", trial.frames},
                              {"placed", trial.placed},
                              {"ate_m", trial.ate_m},
                              {"rpe_m", trial.rpe_m ? Json(*trial.rpe_m) : Json(nullptr)},
                              {"cpu_ms",
                               {{"reading", trial.reading_ms},
                                {"features", trial.features_ms},
                                {"views", trial.views_ms},
                                {"tracking_and_loops", trial.tracking_ms},
                                {"solving", trial.solving_ms},
                                {"floor", trial.floor_ms},
                                {"all", trial.all_ms}}}});
  }
  return json;
}

Json to_json(const studies::ObjectsRow& row) {
  return {{"recording", row.data.name},
          {"simulated", row.data.is_simulated},
          {"way", row.way},
          {"found", row.found},
          {"missed", row.missed},
          {"beyond", row.beyond},
          {"double", row.twice},
          {"false", row.wrong},
          {"from_middle_m", row.from_middle_m ? Json(*row.from_middle_m) : Json(nullptr)}};
}

Json to_json(const studies::RuledObject& object) {
  return {{"recording", object.data.name}, {"simulated", object.data.is_simulated},
          {"name", object.name},           {"score", object.score},
          {"keyframes", object.keyframes}, {"has_place", object.has_place}};
}

Json to_json(const studies::RoomsRow& row) {
  return {{"changed", row.changed},
          {"data", row.data.name},
          {"simulated", row.data.is_simulated},
          {"way", row.way},
          {"n", row.decisions},
          {"named", row.right_of_named.n},
          {"right", row.right_of_named.successes},
          {"interval", {row.interval.low, row.interval.high}},
          {"ms", row.ms}};
}

Json to_json(const evaluation::TrainingReportContent& training) {
  const auto or_null = [](double value) {
    return std::isfinite(value) ? Json(value) : Json(nullptr);
  };
  Json curve = Json::array();
  for (const auto& point : training.points) {
    curve.push_back({{"step", point.step},
                     {"cross_entropy", or_null(point.cross_entropy)},
                     {"held_out_cross_entropy", or_null(point.held_out_cross_entropy)},
                     {"held_out_precision", or_null(point.held_out_precision)}});
  }
  return {{"network", training.network}, {"best_step", training.best_step}, {"curve", curve}};
}

template <typename Row>
Json list_of(const std::vector<Row>& rows) {
  Json list = Json::array();
  for (const Row& row : rows) list.push_back(to_json(row));
  return list;
}

Answer answer_of(const PaperResults& results, const PaperOptions& options) {
  Answer answer;
  Json& json = answer.json;
  json["seeds"] = results.seeds;
  json["networks"] = results.networks;
  json["mapping"] = list_of(results.mapping);
  json["objects"] = list_of(results.objects);
  json["objects_by_rules"] = list_of(results.ruled_objects);
  json["rooms"] = list_of(results.rooms);
  json["training"] = results.training ? to_json(*results.training) : Json(nullptr);
  for (const auto& [part, name] : studies::kPaperParts) {
    const auto missing = results.missing.find(part);
    if (missing == results.missing.end() || missing->second.empty()) continue;
    json["missing"][std::string(name)] = missing->second;
    answer.text += fmt::format("missing, {}:\n", name);
    for (const std::string& sentence : missing->second) answer.text += "  " + sentence + "\n";
  }
  json["page"] = options.output.string();
  answer.text += fmt::format("wrote {}; what is done is kept in {}\n", options.output.string(),
                             options.study.work.string());
  return answer;
}

// The network whose training the table of training shows, where it is installed.
std::optional<fs::path> trained_network() {
  auto found = find_network_file("mobilenet-v2-imagenet");
  return found ? std::optional(std::move(*found)) : std::nullopt;
}

Expected<Answer> run(const PaperOptions& given, Context& context) {
  PaperOptions options = given;
  studies::PaperStudyOptions& study = options.study;
  if (study.work.empty()) study.work = options.output.string() + ".work";
  if (!options.only.empty()) study.parts.clear();
  for (const auto& [part, name] : studies::kPaperParts) {
    if (std::ranges::find(options.only, name) != options.only.end()) study.parts.push_back(part);
  }
  ROOMWISE_RETURN_IF_ERROR(study.validate());
  ROOMWISE_RETURN_IF_ERROR(check_can_write(options.output));
  studies::KnownDigests of_programs;
  ROOMWISE_TRY(study.version, version_of_programs(of_programs));
  study.first_seed = context.seed;
  ROOMWISE_TRY(study.networks, usable_networks());
  study.trained = trained_network();
  study.more = {"--threads", std::to_string(context.threads)};
  const auto results =
      studies::study_paper(study, studies::roomwise_beside(context.progress), context.progress);
  if (!results && results.error().code == ErrorCode::kInterrupted) {
    return fail_with(ErrorCode::kInterrupted, "{}; the same command goes on from there",
                     results.error().message);
  }
  if (!results) return Unexpected(results.error());
  ROOMWISE_RETURN_IF_ERROR(write_file(options.output, studies::paper_page(*results)));
  return answer_of(*results, options);
}

}  // namespace

void add_paper_command(CLI::App& app, Context& context) {
  const auto [command, options] = add_command<PaperOptions>(
      app, context, "paper",
      "Make the tables of the paper that Roomwise follows anew, by its methods and by today's "
      "default, beside what was published; from the recordings that are at hand, naming those that "
      "are not",
      "roomwise-lab paper --data recordings -o tables.html --seed 1\n"
      "It may take an hour. What is done is kept: after Ctrl-C the same command goes on.",
      run);
  command
      ->add_option("--data", options.study.data,
                   "Folder that holds rgbd_dataset_freiburg1_desk and others, office_walk, "
                   "room_photos, as many as there are")
      ->envname("ROOMWISE_DATA")
      ->required();
  command->add_option("-o,--output", options.output, "Page to write (.html)")->required();
  command->add_option("--work", options.study.work,
                      "Folder of its own in which what is done is kept; default: the page's name "
                      "with .work");
  command->add_option("--truth", options.study.truth,
                      "Folder of RECORDING.objects.json, the objects that people marked: "
                      "tests/truth of a checkout");
  command
      ->add_option("--only", options.only,
                   "These tables alone, separated by commas: mapping (with times), objects, rooms, "
                   "training")
      ->delimiter(',')
      ->check(CLI::IsMember({"mapping", "objects", "rooms", "training"}));
  add_setting(*command, "--seeds", options.study.seeds,
              "Maps of each recording, method and kind of feature, from --seed on", positive());
}

}  // namespace roomwise::app
