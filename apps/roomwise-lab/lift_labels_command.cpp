#include <filesystem>

#include "camera_option.h"
#include "commands.h"
#include "figures.h"
#include "laboratory/labelling/lift_labels.h"
#include "roomwise/recording/open_recording.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

struct LiftLabelsOptions {
  fs::path recording;
  std::string camera;
  std::vector<fs::path> labels;
  fs::path output;
};

Expected<Answer> lift(const LiftLabelsOptions& options, Context& /*context*/) {
  if (options.labels.size() > 2) return fail("--labels: one reader's file or two, no more");
  ROOMWISE_TRY(const auto camera, given_camera(options.camera));
  ROOMWISE_TRY(const auto recording,
               recording::open_recording(options.recording, {.camera = camera}));
  ROOMWISE_TRY(const auto poses, recording::read_truth(options.recording));
  std::vector<labelling::LiftedLabels> readers;
  Answer answer;
  answer.json["readers"] = Json::array();
  for (const fs::path& file : options.labels) {
    ROOMWISE_TRY(const auto labels, labelling::read_reader_labels(file));
    auto lifted = lift_labels(labels, *recording, poses);
    if (!lifted) return fail("{}: {}", file.string(), lifted.error().message);
    std::vector<double> sigmas_m, residuals_px;
    for (const auto& [label, thing] : lifted->things) {
      sigmas_m.push_back(thing.sigma_m);
      if (thing.residual_px) residuals_px.push_back(*thing.residual_px);
    }
    const auto sigma_m = quantile_of(sigmas_m, 0.5), residual_px = quantile_of(residuals_px, 0.5);
    answer.text += fmt::format(
        "reader {}: {} things in space, {} whose place is not known; middles known to {} m, "
        "{} px from their boxes' where two or more show all (medians)\n",
        labels.reader, lifted->things.size(), lifted->not_lifted.size(), text_or_none(sigma_m),
        text_or_none(residual_px, 1));
    for (const labelling::LabelledThing& thing : lifted->not_lifted) {
      answer.text += fmt::format("  not in space: {} {} {}\n", thing.id, thing.name, thing.note);
    }
    answer.json["readers"].push_back({{"reader", labels.reader},
                                      {"things", lifted->things.size()},
                                      {"not_in_space", lifted->not_lifted.size()},
                                      {"sigma_m", json_or_null(sigma_m)},
                                      {"residual_px", json_or_null(residual_px)}});
    readers.push_back(*std::move(lifted));
  }
  labelling::ReaderAgreement agreement;
  ROOMWISE_TRY(const labelling::RecordingTruth truth, merge_readers(readers, agreement));
  ROOMWISE_RETURN_IF_ERROR(write_recording_truth(options.output, truth));
  const auto between_m = quantile_of(agreement.between_m, 0.5);
  answer.text +=
      fmt::format("marked by both {}, under two names {}, by one alone {}\n", agreement.both,
                  agreement.other_name, fmt::join(agreement.only_one, " and "));
  if (between_m) {
    answer.text += fmt::format("the readers' middles lie {:.2f} m apart (median)\n", *between_m);
  }
  answer.text += fmt::format("{} things in {}\n", truth.things.size(), options.output.string());
  answer.json["both"] = agreement.both;
  answer.json["other_name"] = agreement.other_name;
  answer.json["only_one"] = agreement.only_one;
  answer.json["between_m"] = json_or_null(between_m);
  answer.json["things"] = truth.things.size();
  return answer;
}

}  // namespace

void add_lift_labels_command(CLI::App& app, Context& context) {
  const auto [command, options] = add_command<LiftLabelsOptions>(
      app, context, "lift-labels",
      "Make the truth of a real recording of the boxes that readers drew in its pictures",
      "roomwise-lab lift-labels office_walk --labels a.json --labels b.json -o "
      "office.objects.json\n"
      "What two readers marked alike is expected to be found; eval objects takes the file.",
      lift);
  command
      ->add_option("recording", options.recording,
                   "Recording with groundtruth.txt or its device's own poses")
      ->required()
      ->check(CLI::ExistingPath);
  add_camera_option(*command, options.camera, "the recording's own");
  command->add_option("--labels", options.labels, "A reader's file; twice for two readers")
      ->required()
      ->check(CLI::ExistingFile);
  command->add_option("-o,--output", options.output, "File to write")->required();
}

}  // namespace roomwise::app
