#include <filesystem>

#include "commands.h"
#include "roomwise/base/file.h"
#include "roomwise/evaluation/drawing/trajectory_plot.h"
#include "roomwise/evaluation/errors/trajectory_error.h"
#include "roomwise/recording/open_recording.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;
using evaluation::AbsoluteTrajectoryError;
using evaluation::ErrorStatistics;
using evaluation::RelativePoseError;

struct TrajectoryOptions {
  fs::path truth;
  fs::path estimate;
  fs::path plot;  // empty: none
  double max_time_difference_s = 0.02;
  double delta_s = 1;
};

Json to_json(const ErrorStatistics& error) {
  return {{"rmse", error.rmse}, {"mean", error.mean}, {"median", error.median},
          {"std", error.std},   {"min", error.min},   {"max", error.max}};
}

Answer describe(const AbsoluteTrajectoryError& absolute,
                const Expected<RelativePoseError>& relative, double delta_s) {
  Answer answer;
  const ErrorStatistics& error_m = absolute.error_m;
  answer.text = fmt::format(
      "{} pairs of poses\n"
      "ATE {:.4f} m RMSE (mean {:.4f}, median {:.4f}, max {:.4f})\n"
      "best scale {:.4f}: {:.4f} m RMSE with it\n",
      absolute.pairs.size(), error_m.rmse, error_m.mean, error_m.median, error_m.max,
      absolute.best_scale, absolute.scaled_rmse_m);
  answer.json = {{"pairs", absolute.pairs.size()},
                 {"ate_rmse_m", error_m.rmse},
                 {"ate_m", to_json(error_m)},
                 {"best_scale", absolute.best_scale},
                 {"scaled_ate_rmse_m", absolute.scaled_rmse_m}};
  if (relative) {
    answer.text +=
        fmt::format("RPE over {:g} s: {:.4f} m RMSE, {:.3f} degrees RMSE ({} pairs)\n", delta_s,
                    relative->translation_m.rmse, relative->rotation_deg.rmse, relative->count);
    answer.json["rpe"] = {{"delta_s", delta_s},
                          {"count", relative->count},
                          {"translation_m", to_json(relative->translation_m)},
                          {"rotation_deg", to_json(relative->rotation_deg)}};
  } else {
    // A short or sparse trajectory has an ATE, but no two poses that far apart.
    answer.text += fmt::format("RPE over {:g} s: none, {}\n", delta_s, relative.error().message);
    answer.json["rpe"] = nullptr;
  }
  return answer;
}

Expected<Answer> run(const TrajectoryOptions& options, Context& /*context*/) {
  ROOMWISE_TRY(const recording::Trajectory truth, recording::read_truth(options.truth));
  ROOMWISE_TRY(const recording::Trajectory estimate, recording::read_trajectory(options.estimate));
  const auto absolute =
      evaluation::absolute_trajectory_error(truth, estimate, options.max_time_difference_s);
  if (!absolute) {
    return fail("{} and {}: {}", options.truth.string(), options.estimate.string(),
                absolute.error().message);
  }
  const auto relative = evaluation::relative_pose_error(
      truth, estimate,
      {.delta = options.delta_s, .max_time_difference_s = options.max_time_difference_s});
  Answer answer = describe(*absolute, relative, options.delta_s);
  if (!options.plot.empty()) {
    const auto plot = evaluation::plot_trajectory(
        *absolute,
        {.title = options.estimate.filename().string(), .up = evaluation::axis_nearest_up(truth)});
    ROOMWISE_RETURN_IF_ERROR(write_file(options.plot, plot.file()));
    answer.text += fmt::format("wrote {}\n", options.plot.string());
    answer.json["plot"] = options.plot.string();
  }
  return answer;
}

}  // namespace

void add_eval_commands(CLI::App& app, Context& context) {
  CLI::App* group =
      add_group(app, "eval", "Measure results against the truth",
                "roomwise eval trajectory --truth groundtruth.txt --estimate trajectory.txt");
  const auto [command, options] = add_command<TrajectoryOptions>(
      *group, context, "trajectory",
      "Absolute and relative trajectory error (ATE, RPE) as the TUM RGB-D benchmark defines them",
      "roomwise eval trajectory --truth groundtruth.txt --estimate trajectory.txt --plot ate.svg",
      run);
  command
      ->add_option(
          "--truth", options.truth,
          "True trajectory (TUM), or a recording: its groundtruth.txt, else its device's poses")
      ->required();
  command->add_option("--estimate", options.estimate, "Estimated trajectory (TUM)")->required();
  command->add_option("--plot", options.plot,
                      "SVG to draw: truth black, estimate blue, differences red");
  add_setting(*command, "--max-difference", options.max_time_difference_s,
              "Maximum time difference between the two poses of a pair, s", CLI::Range(0.0, 1e9));
  add_setting(*command, "--delta", options.delta_s,
              "Time over which the relative error is measured, s", positive());
  add_laboratory_evaluations(*group, context);
}

}  // namespace roomwise::app
