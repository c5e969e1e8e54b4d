#include "laboratory/trials/localization_evaluation.h"

#include <map>
#include <optional>
#include <utility>

#include "laboratory/trials/truth_evaluation.h"
#include "roomwise/mapping/localization/lens_calibration.h"
#include "roomwise/recording/association.h"
#include "roomwise/recording/open_recording.h"
#include "roomwise/recording/trajectory_file.h"

namespace roomwise::trials {
namespace {

using geometry::RigidTransform;

// A frame of the visit, and the one before it where pairs are asked for.
struct Question {
  image::RgbdFrame frame;
  std::optional<image::RgbdFrame> before;
  RigidTransform truth_from_camera;
};

// The answer to a question, right or wrong by the truth.
struct Asker {
  const pipeline::HomeLocalizer& home;
  const geometry::PinholeCamera& camera;
  bool with_depth;
  RigidTransform truth_from_world;

  [[nodiscard]] LocalizationTrial ask(const Question& question) const;
  [[nodiscard]] LocalizationTrial ask(const Question& question,
                                      mapping::LensCalibration& lens) const;

 private:
  void judge(const Question& question, LocalizationTrial& trial) const;
};

LocalizationTrial Asker::ask(const Question& question) const {
  const auto measure = [&](const image::RgbdFrame& frame) {
    return home.measure(
        {frame.color, with_depth ? std::optional(frame.depth) : std::nullopt, camera});
  };
  LocalizationTrial trial;
  const double start_s = thread_cpu_time_s();
  // Frames of a recording have its camera's size.
  const motion::FrameMeasurements second = measure(question.frame).value();
  if (question.before) {
    const motion::FrameMeasurements first = measure(*question.before).value();
    trial.answer = home.localizer().locate({first, camera}, {second, camera}).second;
  } else {
    trial.answer = home.localizer().locate({second, camera});
  }
  trial.cpu_s = thread_cpu_time_s() - start_s;
  judge(question, trial);
  return trial;
}

LocalizationTrial Asker::ask(const Question& question, mapping::LensCalibration& lens) const {
  LocalizationTrial trial;
  trial.focal_ratio = lens.known().camera(camera.width, camera.height).fx / camera.fx;
  const double start_s = thread_cpu_time_s();
  trial.answer = home.locate_uncalibrated(question.frame.color, lens.estimate()).value();
  lens.add(trial.answer);
  trial.cpu_s = thread_cpu_time_s() - start_s;
  judge(question, trial);
  return trial;
}

void Asker::judge(const Question& question, LocalizationTrial& trial) const {
  trial.frame_index = question.frame.index;
  const RigidTransform error =
      question.truth_from_camera.inverse() * truth_from_world * trial.answer.world_from_camera;
  trial.error_m = error.distance_m();
  trial.error_rad = error.angle_rad();
}

// True poses by the index of the colour image.
std::map<std::uint64_t, RigidTransform> true_poses(const recording::Recording& recording,
                                                   const recording::Trajectory& truth) {
  constexpr TimestampNs kTolerance_ns = 20'000'000;
  std::vector<TimestampNs> times_ns, picture_times_ns;
  for (const auto& picture : recording.pictures()) picture_times_ns.push_back(picture.timestamp_ns);
  for (const recording::StampedPose& pose : truth) times_ns.push_back(pose.timestamp_ns);
  std::map<std::uint64_t, RigidTransform> poses;
  for (const recording::Association& pair :
       recording::associate(picture_times_ns, times_ns, kTolerance_ns)) {
    poses.emplace(recording.pictures()[pair.first].index, truth[pair.second].world_from_camera);
  }
  return poses;
}

}  // namespace

Expected<std::vector<LocalizationTrial>> evaluate_localization(
    const home::Home& home, const std::filesystem::path& mapped_recording,
    const std::filesystem::path& visit, const mapping::LocalizerOptions& localizer,
    const LocalizationEvaluationOptions& options, pipeline::RunContext& run) {
  if (options.every < 1) return fail("every = {} must be at least 1", options.every);
  ROOMWISE_TRY(const RigidTransform truth_from_world, truth_from_map(home, mapped_recording));
  ROOMWISE_TRY(const auto recording, recording::open_recording(visit));
  ROOMWISE_TRY(const recording::Trajectory truth, recording::read_truth(visit));
  const auto poses = true_poses(*recording, truth);
  ROOMWISE_TRY(const pipeline::HomeLocalizer home_localizer,
               pipeline::HomeLocalizer::create(home, localizer, run));
  const geometry::PinholeCamera& camera = recording->info().camera;

  const Asker asker{home_localizer, camera, options.with_depth, truth_from_world};
  mapping::LensCalibration lens;

  std::vector<LocalizationTrial> trials;
  std::vector<Question> block;
  const auto ask_block = [&] {
    const std::size_t first = trials.size();
    trials.resize(first + block.size());
    if (options.unknown_lens) {  // each picture by what the earlier ones told
      for (std::size_t i = 0; i < block.size(); ++i) trials[first + i] = asker.ask(block[i], lens);
    } else {
      run.pool.parallel_for(block.size(),
                            [&](std::size_t i) { trials[first + i] = asker.ask(block[i]); });
    }
    block.clear();
  };
  run.progress.begin("localising", recording->frames().size());
  std::optional<image::RgbdFrame> before;
  for (std::uint64_t count = 0; !run.progress.interrupted(); ++count) {
    ROOMWISE_TRY(auto frame, recording->next());
    if (!frame) break;
    const auto pose = poses.find(frame->index);
    if (count % options.every == 0 && pose != poses.end() && (!options.pairs || before)) {
      block.push_back({*frame, options.pairs ? before : std::nullopt, pose->second});
    }
    before = std::move(frame);
    if (block.size() >= 4 * run.pool.size()) ask_block();
    run.progress.advance(count + 1, "");
  }
  ask_block();
  run.progress.end();
  ROOMWISE_RETURN_IF_ERROR(run.progress.check("localising"));
  return trials;
}

}  // namespace roomwise::trials
