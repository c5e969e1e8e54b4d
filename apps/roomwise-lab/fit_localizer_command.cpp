#include <filesystem>
#include <opencv2/core/utility.hpp>
#include <vector>

#include "case_words.h"
#include "command_run.h"
#include "commands.h"
#include "laboratory/trials/localization_fitting.h"
#include "open_home.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

struct FitLocalizerOptions {
  std::vector<std::string> cases;
  fs::path evidence;
  std::uint64_t every = 2;
};

Expected<trials::PoseCase> read_case(const std::string& text, const FitLocalizerOptions& options,
                                     Context& context) {
  auto [parts, sources] = split_case(text);
  const auto has = [&](std::string_view word) { return std::ranges::count(parts, word) > 0; };
  if (parts.size() < 3) {
    return fail(
        "--case {}: expected HOME,TRUTH,VISIT, of real, elsewhere, phone what holds, and "
        "source=NAME",
        text);
  }
  for (std::size_t i = 3; i < parts.size(); ++i) {
    if (parts[i] != "real" && parts[i] != "elsewhere" && parts[i] != "phone")
      return fail("--case {}: '{}' is none of real, elsewhere, phone, source=NAME", text, parts[i]);
  }
  if (sources.empty()) {
    for (const std::string& recording : {parts[1], parts[2]}) {
      ROOMWISE_TRY(std::string place, trials::place_of(recording));
      sources.insert(std::move(place));
    }
  }
  ROOMWISE_TRY(const home::Home home, open_home_read_only(parts[0], context));
  CommandRun run(context);
  mapping::LocalizerOptions localizer;
  localizer.seed = context.seed;
  ROOMWISE_TRY(
      const auto trials,
      trials::evaluate_localization(
          home, parts[1], parts[2], localizer,
          {.every = options.every, .with_depth = false, .unknown_lens = has("phone")}, run));
  return trials::pose_case(
      fs::path(parts[2]).filename().string() + " on " + fs::path(parts[0]).filename().string(),
      std::move(sources), has("real"), has("elsewhere"), trials);
}

Expected<void> write_evidence(const fs::path& path, const std::vector<trials::PoseCase>& cases) {
  std::string lines;
  for (const trials::PoseCase& one : cases) {
    for (std::size_t i = 0; i < one.evidence.size(); ++i) {
      Json line{{"case", one.name},
                {"sources", one.sources},
                {"real", one.is_real},
                {"right", bool{one.is_right[i]}}};
      for (std::size_t e = 0; e < one.evidence[i].size(); ++e) {
        line[std::string(mapping::kPoseEvidenceNames.at(e))] = one.evidence[i][e];
      }
      lines += line.dump() + "\n";
    }
  }
  return write_file(path, lines);
}

std::string text_of(const trials::PoseCounts& counts) {
  return fmt::format("{:>6.3f} {:>5}",
                     static_cast<double>(counts.right) /
                         static_cast<double>(std::max<std::size_t>(1, counts.pictures)),
                     counts.wrong);
}

Expected<Answer> fit(const FitLocalizerOptions& options, Context& context) {
  cv::setNumThreads(1);
  std::vector<trials::PoseCase> cases;
  for (const std::string& text : options.cases) {
    ROOMWISE_TRY(cases.emplace_back(), read_case(text, options, context));
  }
  if (!options.evidence.empty()) ROOMWISE_RETURN_IF_ERROR(write_evidence(options.evidence, cases));
  Answer answer;
  answer.text =
      fmt::format("{:<44} {:>8}  {:^12}  {:^12}\n{:<44} {:>8}  {:>12}  {:>12}\n", "left out",
                  "pictures", "fitted", "40 inliers", "", "", "right wrong", "right wrong");
  for (const trials::PoseCase& one : cases) {
    ROOMWISE_TRY(const mapping::PoseModel model,
                 trials::fit_poses(trials::of_other_sources(cases, one)));
    answer.text +=
        fmt::format("{:<44} {:>8}  {}  {}\n", one.name, one.pictures,
                    text_of(trials::counts_of(one, model)), text_of(trials::naive_counts(one)));
  }
  ROOMWISE_TRY(const mapping::PoseModel model, trials::fit_poses(cases));
  answer.json = {{"bias", model.bias}, {"min_probability", model.min_probability}};
  answer.text +=
      fmt::format("bias {:.4f}, min_probability {:.5f}", model.bias, model.min_probability);
  for (std::size_t i = 0; i < model.weights.size(); ++i) {
    const std::string name(mapping::kPoseEvidenceNames.at(i));
    answer.json["weights"][name] = model.weights[i];
    answer.text += fmt::format(", {} {:.4f}", name, model.weights[i]);
  }
  answer.text += '\n';
  return answer;
}

}  // namespace

void add_fit_localizer_command(CLI::App& app, Context& context) {
  const auto [command, options] = add_command<FitLocalizerOptions>(
      app, context, "fit-localizer",
      "Fit the model that says which poses of pictures without depth are right",
      "roomwise-lab fit-localizer --case flat.home,flat,flat-night \\\n"
      "  --case office.home,office,flat-night,elsewhere\n"
      "Each case is left out, with all of its source, of the fit that measures it. The numbers go\n"
      "into\n"
      "mapping::PoseModel::fitted().",
      fit);
  command
      ->add_option(
          "--case", options.cases,
          "HOME,TRUTH,VISIT; with ,real of real recordings, ,elsewhere where the visit is "
          "of another home, ,phone to be localised without calibration; ,source=NAME, also "
          "twice: cases of one source share pictures and are left out together; default: "
          "the places of TRUTH and VISIT, of simulated recordings their homes, of real "
          "ones their names")
      ->required();
  command->add_option("--evidence", options.evidence, "Write all poses, a JSON object a line");
  add_setting(*command, "--every", options.every, "Ask about every N-th frame",
              CLI::PositiveNumber);
}

}  // namespace roomwise::app
