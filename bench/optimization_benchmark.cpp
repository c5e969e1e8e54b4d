// Optimises public pose graphs, and one that is made here, by Roomwise's solver and by Ceres, and
// prints what that costs:
//   optimization_benchmark [RUNS]
// Graphs are looked for in ROOMWISE_DATA/pose_graphs. Reading the file is not counted; checking it,
// building the problem and planning the elimination are.

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "arguments.h"
#include "roomwise/mapping/graph/g2o_file.h"
#include "roomwise/mapping/testing/ceres_pose_graph.h"
#include "roomwise/mapping/testing/torus_graph.h"

namespace {

using namespace roomwise;

struct Run {
  double error = 0;
  double iterations = 0;
  double cpu_ms = 0;
  double wall_ms = 0;
};

struct Way {
  std::string name;
  std::function<int(mapping::PoseGraph&)> optimize;  // the number of iterations
};

int by_roomwise(mapping::PoseGraph& graph, bool relaxes_start) {
  const auto report = mapping::optimize(graph, {.relaxes_start = relaxes_start});
  if (!report) {
    fmt::print(stderr, "{}\n", report.error().message);
    std::exit(1);
  }
  return report->iterations;
}

Way by_ceres(std::string name, const ceres::Solver::Options& options) {
  return {std::move(name), [options](mapping::PoseGraph& graph) {
            const auto summary = mapping::testing::optimize_with_ceres(graph, 0, options);
            return static_cast<int>(summary.iterations.size()) - 1;
          }};
}

std::vector<Way> ways() {
  std::vector<Way> result;
  for (const bool relaxes : {true, false}) {
    result.push_back(
        {fmt::format("Roomwise (1 thread{})", relaxes ? "" : ", from the poses given"),
         [relaxes](mapping::PoseGraph& graph) { return by_roomwise(graph, relaxes); }});
  }
  for (const int threads : {1, 2}) {
    ceres::Solver::Options defaults;
    defaults.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    defaults.num_threads = threads;
    defaults.logging_type = ceres::SILENT;
    result.push_back(
        by_ceres(fmt::format("Ceres, default limits, {} thread(s)", threads), defaults));
    ceres::Solver::Options thorough = defaults;
    thorough.max_num_iterations = 100;
    thorough.function_tolerance = 1e-9;
    thorough.gradient_tolerance = 1e-12;
    thorough.parameter_tolerance = 1e-12;
    result.push_back(
        by_ceres(fmt::format("Ceres, Roomwise's limits, {} thread(s)", threads), thorough));
  }
  return result;
}

Run run_once(const mapping::PoseGraph& start, const Way& way) {
  mapping::PoseGraph graph = start;
  const std::clock_t cpu = std::clock();
  const auto wall = std::chrono::steady_clock::now();
  Run run;
  run.iterations = way.optimize(graph);
  run.cpu_ms = 1000.0 * static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
  run.wall_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - wall).count();
  run.error = mapping::pose_graph_chi2(graph);
  return run;
}

std::string median_and_range(const std::vector<Run>& runs, double Run::*field) {
  std::vector<double> values;
  for (const Run& run : runs) values.push_back(run.*field);
  std::ranges::sort(values);
  return fmt::format("{:.1f} ({:.1f} to {:.1f})", values[values.size() / 2], values.front(),
                     values.back());
}

}  // namespace

int main(int argc, char** argv) {
  const char* data = std::getenv("ROOMWISE_DATA");
  constexpr std::string_view kUsage = "ROOMWISE_DATA=FOLDER optimization_benchmark [RUNS]";
  const auto given = bench::only_count(argc, argv, 5, kUsage);
  if (!given) {
    fmt::print(stderr, "{}\n", given.error().message);
    return 2;
  }
  if (data == nullptr) {
    fmt::print(stderr, "usage: {}\n", kUsage);
    return 2;
  }
  const int runs = *given;
  fmt::print("Median (range) of {} runs.\n\n", runs);
  fmt::print("| graph | solver | F | iterations | CPU-ms | wall ms |\n");
  fmt::print("| --- | --- | --- | --- | --- | --- |\n");
  std::vector<std::pair<std::string, mapping::PoseGraph>> graphs;
  for (const char* name : {"sphere2500", "parking-garage", "smallGrid3D"}) {
    auto graph = mapping::read_g2o(std::filesystem::path(data) / "pose_graphs" /
                                   fmt::format("{}.g2o", name));
    if (!graph) {
      fmt::print(stderr, "{}\n", graph.error().message);
      return 1;
    }
    graphs.emplace_back(name, *std::move(graph));
  }
  graphs.emplace_back("noisy torus", mapping::testing::torus_graph());
  for (const auto& [name, graph] : graphs) {
    for (const Way& way : ways()) {
      std::vector<Run> results;
      for (int i = 0; i < runs; ++i) results.push_back(run_once(graph, way));
      fmt::print("| {} | {} | {:.8g} | {:.0f} | {} | {} |\n", name, way.name, results.front().error,
                 results.front().iterations, median_and_range(results, &Run::cpu_ms),
                 median_and_range(results, &Run::wall_ms));
      std::fflush(stdout);
    }
  }
  return 0;
}
