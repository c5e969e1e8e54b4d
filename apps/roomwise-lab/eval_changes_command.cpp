#include <filesystem>
#include <opencv2/core/utility.hpp>

#include "command_run.h"
#include "commands.h"
#include "laboratory/trials/change_evaluation.h"
#include "networks.h"
#include "open_home.h"
#include "roomwise/recording/open_recording.h"

namespace roomwise::app {
namespace {

struct ChangesEvaluationOptions {
  std::filesystem::path home, truth, visit;
  double min_shift_m = 0.1;
  pipeline::UpdateOptions update;
};

Json to_json(const trials::TrueChange& change) {
  return {{"name", change.name},
          {"label", change.label},
          {"what", change.state ? objects::to_string(*change.state) : "new"},
          {"shift_m", change.shift_m},
          {"expected", change.is_expected},
          {"known", change.was_known},
          {"noticed_as", change.noticed_as},
          {"noticed_unnamed", change.is_noticed_unnamed}};
}

std::string noticed_as(const trials::TrueChange& change) {
  if (!change.noticed_as.empty()) return fmt::format("{}", fmt::join(change.noticed_as, ", "));
  return change.is_noticed_unnamed ? "as something" : "not noticed";
}

Expected<Answer> evaluate(const ChangesEvaluationOptions& options, Context& context) {
  cv::setNumThreads(1);
  ROOMWISE_TRY(const objects::ObjectFinders finders, load_object_finders());
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  CommandRun run(context);
  pipeline::UpdateOptions with = options.update;
  with.visit.localizer.seed = context.seed;
  with.visit.rooms.reset();
  ROOMWISE_TRY(const auto visit, recording::open_recording(options.visit));
  ROOMWISE_TRY(const pipeline::HomeUpdate update,
               pipeline::compare_with_visit(home, {*visit, *visit}, finders, {}, with, run));
  ROOMWISE_TRY(
      const trials::ChangeEvaluation result,
      trials::evaluate_changes(home, options.truth, options.visit, update, options.min_shift_m));
  Answer answer;
  answer.json = {{"expected", result.expected()},
                 {"noticed", result.noticed()},
                 {"known", result.known()},
                 {"known_noticed", result.known_noticed()},
                 {"right_alarms", result.right},
                 {"wrong_alarms", result.wrong},
                 {"unchanged", result.unchanged},
                 {"noticed_with_unnamed", result.noticed_with_unnamed()},
                 {"unnamed_right", result.unnamed_right},
                 {"unnamed_doors", result.unnamed_doors},
                 {"unnamed_wrong", result.unnamed_wrong},
                 {"changes", Json::array()}};
  for (const trials::TrueChange& change : result.changes) {
    answer.json["changes"].push_back(to_json(change));
    answer.text += fmt::format("{:<6} {:<20} {:>5.2f} m {:<30} {}\n",
                               change.state ? objects::to_string(*change.state) : "new",
                               change.name, change.shift_m,
                               !change.is_expected ? "hardly seen"
                               : change.was_known  ? "seen well, known to the home"
                                                   : "seen well",
                               noticed_as(change));
  }
  answer.text += fmt::format(
      "noticed: {} of {} things of known kinds that changed and were seen well; {} of {} that the "
      "home knew\n"
      "alarms: {} right, {} wrong{}; no alarm about {} things\n",
      result.noticed(), result.expected(), result.known_noticed(), result.known(), result.right,
      result.wrong.size(),
      result.wrong.empty() ? "" : fmt::format(" ({})", fmt::join(result.wrong, ", ")),
      result.unchanged);
  answer.text += fmt::format(
      "with what has no name: {} of {} noticed; {} right, {} doors' leaves that were turned, {} "
      "wrong{}\n",
      result.noticed_with_unnamed(), result.expected(), result.unnamed_right, result.unnamed_doors,
      result.unnamed_wrong.size(),
      result.unnamed_wrong.empty() ? ""
                                   : fmt::format(" ({})", fmt::join(result.unnamed_wrong, "; ")));
  return answer;
}

}  // namespace

void add_changes_evaluation(CLI::App& group, Context& context) {
  const auto [command, options] = add_command<ChangesEvaluationOptions>(
      group, context, "changes",
      "What a later simulated walk is said to have changed in a home, against the truth of both "
      "walks",
      "roomwise eval changes --home flat.home --truth flat-day --visit flat-moved", evaluate);
  command->add_option("--home", options.home, "Home mapped from the recording")->required();
  command->add_option("--truth", options.truth, "Simulated recording that was mapped")->required();
  command->add_option("--visit", options.visit, "Later simulated recording of the same home")
      ->required();
  add_setting(*command, "--min-shift", options.min_shift_m,
              "A thing that was moved by less counts as unmoved, m", positive());
  add_setting(*command, "--every", options.update.visit.every, "Look at every K-th picture",
              CLI::Range(std::uint64_t{1}, std::uint64_t{1000}));
}

}  // namespace roomwise::app
