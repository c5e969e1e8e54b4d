#include <filesystem>
#include <opencv2/core.hpp>

#include "command_run.h"
#include "commands.h"
#include "open_home.h"
#include "readout.h"
#include "roomwise/base/file.h"
#include "roomwise/mapping/graph/g2o_file.h"
#include "roomwise/mapping/graph/pose_graph.h"
#include "roomwise/pipeline/stored/map_settings.h"
#include "roomwise/pipeline/stored/stored_keyframes.h"
#include "roomwise/pipeline/stored/stored_map.h"

namespace roomwise::app {
namespace {

struct OptimizeOptions {
  std::filesystem::path input;
  std::filesystem::path output;
  std::filesystem::path home;
  mapping::PoseGraphOptions graph;
  bool no_upright = false;
};

std::string indefinite_text(std::size_t edges) {
  if (edges == 0) return "";
  return fmt::format(
      "warning: the information of {} edges is not positive semi-definite; where it is negative it "
      "was taken to say nothing\n",
      edges);
}

Answer answer_of(const mapping::PoseGraphReport& report, std::size_t poses, std::size_t edges) {
  return Answer{fmt::format("{} poses, {} edges\n"
                            "F before {:.6g}\n"
                            "F after  {:.6g} ({} iterations, {})\n",
                            poses, edges, report.error_before, report.error_after,
                            report.iterations, geometry::to_string(report.termination)) +
                    indefinite_text(report.indefinite_edges),
                {{"poses", poses},
                 {"edges", edges},
                 {"f_before", report.error_before},
                 {"f_after", report.error_after},
                 {"iterations", report.iterations},
                 {"indefinite_edges", report.indefinite_edges},
                 {"converged", report.termination == geometry::Termination::kConverged}}};
}

Expected<Answer> optimize_file(const OptimizeOptions& options, const Context& context) {
  if (is_database(options.input)) {
    return fail("{}: is a home; give it as --home", options.input.string());
  }
  ROOMWISE_TRY(mapping::PoseGraph graph, mapping::read_g2o(options.input));
  ROOMWISE_TRY(const mapping::PoseGraphReport report,
               mapping::optimize(graph, options.graph, context.progress));
  ROOMWISE_RETURN_IF_ERROR(mapping::write_g2o(options.output, graph));
  Answer answer = answer_of(report, graph.world_from_node.size(), graph.edges.size());
  answer.text += fmt::format("wrote {}\n", options.output.string());
  answer.json["output"] = options.output.string();
  return answer;
}

// The key-frames move, and what was seen from them moves with them.
Expected<Answer> optimize_home(const OptimizeOptions& options, Context& context) {
  ROOMWISE_TRY(home::Home home, open_home(options.home, context));
  ROOMWISE_TRY(auto settings, pipeline::stored_map_settings(home));
  if (!settings) {
    return fail("{}: has no map to optimise; make one with: roomwise map", options.home.string());
  }
  settings->solver.graph = options.graph;
  if (options.no_upright) settings->refinement.uses_gravity = false;
  ROOMWISE_TRY(const mapping::PoseGraph before,
               pipeline::stored_pose_graph(home, settings->solver));
  const double error_before = mapping::pose_graph_chi2(before);
  cv::setNumThreads(1);  // the threads are ours
  CommandRun run(context);
  ROOMWISE_TRY(const mapping::FindFeatures features,
               pipeline::stored_keyframe_features(home, *settings, run));
  auto moved = pipeline::solve_stored_map(home, *settings, features, context.progress);
  if (!moved && moved.error().code == ErrorCode::kInterrupted) {
    return fail_with(ErrorCode::kInterrupted, "interrupted; {} is as it was",
                     options.home.string());
  }
  ROOMWISE_TRY(const pipeline::SolvedMap solved, std::move(moved));
  for (const auto& [id, why] : solved.unread) context.progress.note("not compared: " + why);
  const mapping::MapSolution& solution = solved.solution;
  ROOMWISE_TRY(const pipeline::FoundObjects objects,
               pipeline::update_objects(home, settings->objects));
  ROOMWISE_TRY(const auto edges, home.edges());
  mapping::PoseGraphReport report = solution.report;
  report.error_before = error_before;
  Answer answer = answer_of(report, solution.world_from_keyframe.size(), edges.size());
  answer.text += fmt::format("loops left out  {}\nobjects         {} ({} by the paper's rules)\n",
                             solution.rejected_edges, objects.instances, objects.by_rules);
  if (solved.refinement) {
    answer.text +=
        fmt::format("landmarks       {}, seen {} times, {:.2f} px off; rolling shutter {}\n",
                    solved.refinement->landmarks, solved.refinement->views,
                    solved.refinement->rms_px, readout_text(solved.refinement->readout_s));
    answer.json["landmarks"] = solved.refinement->landmarks;
    answer.json["landmark_views"] = solved.refinement->views;
    answer.json["landmark_rms_px"] = solved.refinement->rms_px;
    answer.json["readout_s"] = readout_json(solved.refinement->readout_s);
  }
  answer.json["upright"] = solved.refinement.has_value() && settings->refinement.uses_gravity;
  answer.json["rejected_loops"] = solution.rejected_edges;
  answer.json["objects"] = objects.by_rules;
  answer.json["instances"] = objects.instances;
  answer.json["home"] = options.home.string();
  return answer;
}

}  // namespace

void add_optimize_command(CLI::App& app, Context& context) {
  const auto [command, options] = add_command<OptimizeOptions>(
      app, context, "optimize",
      "Optimise a pose graph, of a .g2o file or of a home; print F before and after",
      "roomwise optimize sphere2500.g2o -o optimised.g2o\n"
      "  roomwise optimize --home my.home",
      [](const OptimizeOptions& given, Context& with) {
        return given.home.empty() ? optimize_file(given, with) : optimize_home(given, with);
      });
  CLI::Option_group* graph = command->add_option_group("Pose graph");
  CLI::Option* input = graph->add_option("IN", options.input, "Pose graph to read (.g2o, SE3)");
  CLI::Option* home =
      graph->add_option("--home", options.home, "Home whose key-frames are to move");
  graph->require_option(1);
  CLI::Option* output =
      command->add_option("-o,--output", options.output, "Where to write IN optimised");
  input->needs(output);
  output->needs(input);
  add_setting(*command, "--loop-kernel", options.graph.loop_kernel,
              "e^T Omega e of a loop closure above which it counts less and less; 0: never");
  command
      ->add_flag(
          "--no-upright", options.no_upright,
          "Do not hold the home upright by level surfaces and walls, this once (one that was "
          "mapped so never is)")
      ->needs(home);
}

}  // namespace roomwise::app
