#include <filesystem>
#include <memory>

#include "commands.h"
#include "roomwise/mapping/g2o_file.h"
#include "roomwise/mapping/pose_graph.h"

namespace roomwise::app {
namespace {

struct Options {
  std::filesystem::path input;
  std::filesystem::path output;
  mapping::PoseGraphOptions optimization;
};

Expected<Answer> run(const Options& options) {
  ROOMWISE_TRY(mapping::PoseGraph graph, mapping::read_g2o(options.input));
  ROOMWISE_TRY(const mapping::PoseGraphReport report,
               mapping::optimize(graph, options.optimization));
  ROOMWISE_CHECK_OK(mapping::write_g2o(options.output, graph));

  Answer answer;
  answer.text = fmt::format(
      "{} poses, {} edges\n"
      "F before {:.6g}\n"
      "F after  {:.6g} ({} iterations{})\n"
      "wrote {}\n",
      graph.world_from_node.size(), graph.edges.size(), report.error_before, report.error_after,
      report.iterations, report.converged ? "" : ", not converged", options.output.string());
  answer.json = {{"poses", graph.world_from_node.size()}, {"edges", graph.edges.size()},
                 {"f_before", report.error_before},       {"f_after", report.error_after},
                 {"iterations", report.iterations},       {"converged", report.converged},
                 {"output", options.output.string()}};
  return answer;
}

}  // namespace

void add_optimize_command(CLI::App& app, Context& context) {
  auto options = std::make_shared<Options>();
  CLI::App* command = add_command(
      app, context, "optimize", "Optimise the pose graph of a .g2o file; print F before and after",
      "roomwise optimize sphere2500.g2o -o optimised.g2o", [options] { return run(*options); });
  command->add_option("IN", options->input, "Pose graph to read (.g2o, SE3)")->required();
  command->add_option("-o,--output", options->output, "Where to write it optimised")->required();
  command
      ->add_option("--loop-kernel", options->optimization.loop_kernel,
                   "e^T Omega e of a loop closure above which it counts less and less; 0: never")
      ->capture_default_str();
}

}  // namespace roomwise::app
