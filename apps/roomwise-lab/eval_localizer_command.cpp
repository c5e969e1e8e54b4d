#include <filesystem>
#include <map>
#include <opencv2/core/utility.hpp>
#include <vector>

#include "command_run.h"
#include "commands.h"
#include "laboratory/trials/localization_evaluation.h"
#include "open_home.h"
#include "roomwise/evaluation/statistics/proportion.h"
#include "roomwise/evaluation/statistics/quantile.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

using evaluation::quantile;

constexpr double kDegrees = 180 / static_cast<double>(EIGEN_PI);

struct LocalizerEvaluationOptions {
  fs::path home;
  fs::path truth;
  fs::path visit;
  trials::LocalizationEvaluationOptions trials;
  bool without_depth = false;
  double near_m = 0.10;
  double near_degrees = 5;
  double far_m = 0.5;
  double far_degrees = 20;
};

Json to_json(const trials::LocalizationTrial& trial) {
  const mapping::Localization& found = trial.answer;
  Json json = {{"frame", trial.frame_index},
               {"status", to_string(found.status)},
               {"matches", found.matches},
               {"inliers", found.inliers}};
  if (trial.focal_ratio) json["focal_ratio"] = *trial.focal_ratio;
  if (found.has_pose()) {
    json["error_m"] = trial.error_m;
    json["error_degrees"] = kDegrees * trial.error_rad;
    json["position_sigma_m"] = found.position_sigma_m();
    json["rotation_sigma_degrees"] = kDegrees * found.rotation_sigma_rad();
    json["keyframe"] = found.keyframe;
    json["witnesses"] = found.supporting_keyframes;
    json["likeness"] = found.pattern_correlation;
    json["support"] = found.support;
    json["overlap"] = found.agreement.overlap;
    json["agreeing"] = found.agreement.agreeing;
  }
  return json;
}

// How far off the focal length is that was known when a picture was asked for.
std::string describe_focal_length(const std::vector<trials::LocalizationTrial>& trials) {
  std::string text = "focal length over the true one, after pictures:";
  for (const std::size_t pictures : {0, 1, 3, 10, 30, 100}) {
    if (pictures < trials.size() && trials[pictures].focal_ratio)
      text += fmt::format("  {}: {:.3f}", pictures, *trials[pictures].focal_ratio);
  }
  return text + '\n';
}

// All trials as figures.
Answer describe(const std::vector<trials::LocalizationTrial>& trials,
                const LocalizerEvaluationOptions& options) {
  evaluation::Proportion near, beside, far, silent;
  std::vector<double> errors_m, errors_degrees, cpu_ms;
  std::map<std::string, int> reasons;
  Json frames = Json::array();
  for (const trials::LocalizationTrial& trial : trials) {
    const bool found = trial.answer.found();
    const double degrees = kDegrees * trial.error_rad;
    const bool is_near = trial.error_m <= options.near_m && degrees <= options.near_degrees;
    const bool is_far = trial.error_m > options.far_m || degrees > options.far_degrees;
    near.add(found && is_near);
    beside.add(found && !is_near && !is_far);
    far.add(found && is_far);
    silent.add(!found);
    if (found) {
      errors_m.push_back(trial.error_m);
      errors_degrees.push_back(degrees);
    } else {
      ++reasons[std::string(to_string(trial.answer.status))];
    }
    cpu_ms.push_back(1000 * trial.cpu_s);
    frames.push_back(to_json(trial));
  }
  const auto row = [](const std::string& what, const evaluation::Proportion& share) {
    return fmt::format("{:<32} {:5.1f} % ({} of {})\n", what, 100 * share.value(), share.successes,
                       share.n);
  };
  Answer answer;
  answer.text =
      row(fmt::format("within {:g} m and {:g} degrees", options.near_m, options.near_degrees),
          near) +
      row("further off", beside) +
      row(fmt::format("wrong: over {:g} m or {:g} degrees", options.far_m, options.far_degrees),
          far) +
      row("no answer", silent);
  for (const auto& [reason, count] : reasons) {
    answer.text += fmt::format("  {}: {}\n", reason, count);
  }
  if (!errors_m.empty())
    answer.text += fmt::format(
        "error of the answers: median {:.3f} m and {:.2f} degrees, 95 % within {:.3f} m and {:.2f} "
        "degrees\n",
        quantile(errors_m, 0.5), quantile(errors_degrees, 0.5), quantile(errors_m, 0.95),
        quantile(errors_degrees, 0.95));
  answer.text += fmt::format("processor time a question: median {:.0f} ms, 95 % within {:.0f} ms\n",
                             quantile(cpu_ms, 0.5), quantile(cpu_ms, 0.95));
  if (options.trials.unknown_lens) answer.text += describe_focal_length(trials);
  answer.json = {{"questions", trials.size()},
                 {"near", near.value()},
                 {"further_off", beside.value()},
                 {"wrong", far.value()},
                 {"no_answer", silent.value()},
                 {"reasons", reasons},
                 {"median_error_m", Json(nullptr)},
                 {"median_error_degrees", Json(nullptr)},
                 {"median_cpu_ms", quantile(cpu_ms, 0.5)},
                 {"frames", std::move(frames)}};
  if (!errors_m.empty()) {
    answer.json["median_error_m"] = quantile(errors_m, 0.5);
    answer.json["median_error_degrees"] = quantile(errors_degrees, 0.5);
  }
  return answer;
}

Expected<Answer> evaluate(const LocalizerEvaluationOptions& options, Context& context) {
  cv::setNumThreads(1);
  if (options.near_m > options.far_m || options.near_degrees > options.far_degrees) {
    return fail("--near must not be above --far, nor --near-degrees above --far-degrees");
  }
  if (options.trials.unknown_lens && options.trials.pairs) {
    return fail("--unknown-lens asks about single pictures; leave out --pairs");
  }
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  CommandRun run(context);
  mapping::LocalizerOptions localizer;
  localizer.seed = context.seed;
  trials::LocalizationEvaluationOptions trials = options.trials;
  trials.with_depth = !options.without_depth;
  ROOMWISE_TRY(const auto result, trials::evaluate_localization(home, options.truth, options.visit,
                                                                localizer, trials, run));
  if (result.empty()) {
    return fail(
        "{}: there is nothing to ask: no frame that --every (and --pairs) leaves has a true pose "
        "within 0.02 s",
        options.visit.string());
  }
  return describe(result, options);
}

}  // namespace

void add_localizer_evaluation(CLI::App& group, Context& context) {
  const auto [command, options] = add_command<LocalizerEvaluationOptions>(
      group, context, "localizer",
      "Where the frames of another walk through the same home are taken to be",
      "roomwise eval localizer --home flat.home --truth flat-day --visit flat-night", evaluate);
  command->add_option("--home", options.home, "Home mapped from the recording")->required();
  command->add_option("--truth", options.truth, "Recording that was mapped, with groundtruth.txt")
      ->required();
  command
      ->add_option("--visit", options.visit,
                   "Recording of another walk, its groundtruth.txt in the same world")
      ->required();
  add_setting(*command, "--every", options.trials.every, "Ask about every N-th frame",
              CLI::PositiveNumber);
  command->add_flag("--without-depth", options.without_depth, "Localise by colour alone");
  command->add_flag("--unknown-lens", options.trials.unknown_lens,
                    "Localise by colour alone, as of a phone: focal length and distortion are "
                    "found from picture to picture");
  command->add_flag("--pairs", options.trials.pairs,
                    "Two pictures a question: a frame and the one before it");
  const auto add_limit = [&](const char* name, double& value, const char* meaning) {
    add_setting(*command, name, value, meaning, positive());
  };
  add_limit("--near", options.near_m, "An answer is right within this, m");
  add_limit("--near-degrees", options.near_degrees, "and this, degrees");
  add_limit("--far", options.far_m, "An answer is wrong beyond this, m");
  add_limit("--far-degrees", options.far_degrees, "or this, degrees");
}

}  // namespace roomwise::app
