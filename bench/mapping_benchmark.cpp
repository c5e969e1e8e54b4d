// Maps recordings with several seeds, methods and kinds of features, and prints how good and how
// dear that is:
//   mapping_benchmark [SEEDS] [METHOD:FEATURES[:graph] ...] [RECORDING/ ...]
// for example: mapping_benchmark 5 paper:orb, or mapping_benchmark 5 combined:surf walks/day/
// With ":graph" the map is left as the pose graph says, without bundle adjustment. What has a slash
// is the folder of a recording, with its camera.txt and groundtruth.txt; without any, the real
// recordings of ROOMWISE_DATA are mapped.
// Each run is a process of its own, so that its processor time and peak memory are its own.
// No networks: this measures mapping alone.

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arguments.h"
#include "roomwise/evaluation/errors/trajectory_error.h"
#include "roomwise/evaluation/statistics/quantile.h"
#include "roomwise/pipeline/mapping/map_recording.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/stored/stored_map.h"
#include "roomwise/recording/open_recording.h"

namespace {

using namespace roomwise;
namespace fs = std::filesystem;

struct Task {
  std::string recording;
  fs::path folder;
  std::optional<geometry::PinholeCamera> camera;
};

// What a run sends to its parent: plain numbers.
struct Run {
  double frames = 0;
  double placed = 0;
  double ate_m = 0;
  double ate_percent = 0;  // of the path
  double rpe_m = 0;
  double keyframes = 0;
  double edges = 0;            // of the pose graph
  double returns = 0;          // edges to a place seen more than ten key-frames before
  double features_cpu_ms = 0;  // per frame, as the next two
  double views_cpu_ms = 0;
  double tracking_cpu_ms = 0;  // with features that are found on the way
  double solving_cpu_ms = 0;   // the pose graph and the bundle, at the end
  double all_cpu_ms = 0;
  double wall_s = 0;
  double peak_mb = 0;
};

struct Way {
  mapping::MappingMethod method;
  features::FeatureKind features;
  bool bundle_adjustment = true;
};

// "paper:surf"; "combined:surf:graph" stops at the pose graph.
Expected<Way> parse_way(std::string_view text) {
  constexpr std::string_view kGraph = ":graph";
  const bool stops_at_graph = text.ends_with(kGraph);
  if (stops_at_graph) text.remove_suffix(kGraph.size());
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos) return fail("'{}' is not METHOD:FEATURES", text);
  ROOMWISE_TRY(const auto method, mapping::parse_mapping_method(text.substr(0, colon)));
  ROOMWISE_TRY(const auto features, features::parse_feature_kind(text.substr(colon + 1)));
  return Way{method, features, !stops_at_graph};
}

double path_length_m(const recording::Trajectory& trajectory) {
  double length = 0;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    length += (trajectory[i].world_from_camera.translation -
               trajectory[i - 1].world_from_camera.translation)
                  .norm();
  }
  return length;
}

Expected<Run> map_once(const Task& task, const Way& way, std::uint64_t seed) {
  const fs::path& folder = task.folder;
  ROOMWISE_TRY(const auto source, recording::open_recording(folder, {.camera = task.camera}));
  const fs::path file =
      fs::temp_directory_path() / fmt::format("roomwise-benchmark-{}.home", getpid());
  pipeline::MapSettings settings;
  settings.features = way.features;
  settings.mapper = mapping::MapperOptions::of(way.method);
  settings.mapper.seed = seed;
  settings.bundle_adjustment = way.bundle_adjustment;
  Run result;
  {
    ROOMWISE_TRY(home::Home home, pipeline::create_home(file));
    ThreadPool pool(ThreadPool::default_size());
    SilentProgress silent;
    StageClock clock;
    pipeline::RunContext run{pool, silent, clock};
    const auto start = std::chrono::steady_clock::now();
    ROOMWISE_TRY(const pipeline::MapSummary summary,
                 pipeline::map_recording(
                     *source, {task.recording, folder.string(), source->info().camera, {}}, home,
                     {}, settings, run));
    result.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    ROOMWISE_TRY(const recording::Trajectory estimate, pipeline::stored_trajectory(home));
    ROOMWISE_TRY(const recording::Trajectory truth,
                 recording::read_trajectory(folder / "groundtruth.txt"));
    ROOMWISE_TRY(const auto ate, evaluation::absolute_trajectory_error(truth, estimate));
    ROOMWISE_TRY(const auto rpe, evaluation::relative_pose_error(truth, estimate));
    result.frames = static_cast<double>(summary.frames);
    result.placed = static_cast<double>(summary.placed);
    result.keyframes = static_cast<double>(summary.keyframes);
    result.edges = static_cast<double>(summary.edges);
    result.returns = static_cast<double>(summary.loops);
    result.ate_m = ate.error_m.rmse;
    result.ate_percent = 100 * ate.error_m.rmse / path_length_m(truth);
    result.rpe_m = rpe.translation_m.rmse;
    const auto stages = clock.stages();
    const auto per_frame_ms = [&](double seconds) { return 1000 * seconds / result.frames; };
    const auto cpu_ms = [&](const std::string& stage) {
      const auto found = stages.find(stage);
      return found == stages.end() ? 0 : per_frame_ms(found->second.cpu_s);
    };
    result.features_cpu_ms = cpu_ms("features");
    result.views_cpu_ms = cpu_ms("views");
    result.tracking_cpu_ms = cpu_ms("tracking and loops");
    result.solving_cpu_ms = cpu_ms("optimisation");
    result.all_cpu_ms = per_frame_ms(process_cpu_time_s());
  }
  fs::remove(file);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  result.peak_mb = static_cast<double>(usage.ru_maxrss) / 1024;
  return result;
}

// Runs in a child process.
std::optional<Run> map_apart(const Task& task, const Way& way, std::uint64_t seed) {
  std::array<int, 2> pipe_ends{};
  if (pipe(pipe_ends.data()) != 0) return std::nullopt;
  const pid_t child = fork();
  if (child == 0) {
    const Expected<Run> run = map_once(task, way, seed);
    if (!run) {
      fmt::print(stderr, "{}\n", run.error().message);
      _exit(1);
    }
    _exit(write(pipe_ends[1], &*run, sizeof *run) == sizeof *run ? 0 : 1);
  }
  close(pipe_ends[1]);
  Run run;
  const bool whole = read(pipe_ends[0], &run, sizeof run) == sizeof run;
  close(pipe_ends[0]);
  waitpid(child, nullptr, 0);
  return whole ? std::optional(run) : std::nullopt;
}

std::string median_and_range(const std::vector<Run>& runs, double Run::*field, int decimals) {
  std::vector<double> values;
  for (const Run& run : runs) values.push_back(run.*field);
  return evaluation::middle_and_range(std::move(values), decimals);
}

// The real recordings that lie in ROOMWISE_DATA.
Expected<std::vector<Task>> real_recordings() {
  const char* data = std::getenv("ROOMWISE_DATA");
  if (data == nullptr) {
    return fail("name recordings, or set ROOMWISE_DATA to the folder of the real ones");
  }
  ROOMWISE_TRY(const auto fr1, geometry::camera_preset("fr1"));
  std::vector<Task> tasks;
  for (const auto& [name, camera] :
       {std::pair("rgbd_dataset_freiburg1_rpy", std::optional(fr1)),
        std::pair("office_walk", std::optional<geometry::PinholeCamera>())}) {
    const fs::path folder = fs::path(data) / name;
    if (fs::exists(folder)) {
      tasks.push_back({name, folder, camera});
    } else {
      fmt::print(stderr, "{}: not there, left out\n", folder.string());
    }
  }
  return tasks;
}

struct Plan {
  int seeds = 5;
  std::vector<std::string> names;  // of the ways
  std::vector<Way> ways;
  std::vector<Task> tasks;
};

Expected<Plan> plan_from(std::span<char*> arguments) {
  Plan plan;
  if (!arguments.empty()) {
    ROOMWISE_TRY(
        plan.seeds,
        bench::parse_count(arguments[0], "mapping_benchmark [SEEDS [WAY ...] [FOLDER/ ...]]"));
    arguments = arguments.subspan(1);
  }
  for (const std::string argument : arguments) {
    if (argument.find('/') == std::string::npos) {
      plan.names.push_back(argument);
    } else {
      plan.tasks.push_back({argument, argument, std::nullopt});
    }
  }
  if (plan.names.empty()) {
    plan.names = {"combined:surf", "combined:sift", "combined:orb",
                  "paper:surf",    "paper:sift",    "paper:orb"};
  }
  for (const std::string& name : plan.names) {
    ROOMWISE_TRY(const Way way, parse_way(name));
    plan.ways.push_back(way);
  }
  if (plan.tasks.empty()) {
    ROOMWISE_TRY(plan.tasks, real_recordings());
  }
  return plan;
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  const auto plan = plan_from({argv + 1, argv + argc});
  if (!plan) {
    fmt::print(stderr, "{}\n", plan.error().message);
    return 2;
  }
  fmt::print("Median (range) of {} seeds, {} threads.\n\n", plan->seeds,
             ThreadPool::default_size());
  fmt::print(
      "| recording | method | frames with a pose | ATE RMSE, m | of the path, % | RPE over 1 s, m "
      "| key-frames | "
      "edges | returns | "
      "features CPU-ms | views CPU-ms | tracking and loops CPU-ms | solving CPU-ms | all CPU-ms a "
      "frame | wall s | "
      "peak MB |\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- "
      "| --- |\n");
  for (const Task& task : plan->tasks) {
    for (std::size_t i = 0; i < plan->ways.size(); ++i) {
      std::vector<Run> runs;
      for (int seed = 1; seed <= plan->seeds; ++seed) {
        const auto run = map_apart(task, plan->ways[i], static_cast<std::uint64_t>(seed));
        if (!run) return 1;
        runs.push_back(*run);
      }
      fmt::print(
          "| {} | {} | {} of {:.0f} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | "
          "{} "
          "|\n",
          task.recording, plan->names[i], median_and_range(runs, &Run::placed, 0),
          runs.front().frames, median_and_range(runs, &Run::ate_m, 4),
          median_and_range(runs, &Run::ate_percent, 3), median_and_range(runs, &Run::rpe_m, 4),
          median_and_range(runs, &Run::keyframes, 0), median_and_range(runs, &Run::edges, 0),
          median_and_range(runs, &Run::returns, 0),
          median_and_range(runs, &Run::features_cpu_ms, 1),
          median_and_range(runs, &Run::views_cpu_ms, 1),
          median_and_range(runs, &Run::tracking_cpu_ms, 1),
          median_and_range(runs, &Run::solving_cpu_ms, 1),
          median_and_range(runs, &Run::all_cpu_ms, 1), median_and_range(runs, &Run::wall_s, 1),
          median_and_range(runs, &Run::peak_mb, 0));
      std::fflush(stdout);
    }
  }
  return 0;
}
