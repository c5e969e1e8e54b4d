#include "roomwise/mapping/graph/pose_graph_solver.h"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include "roomwise/mapping/graph/block_cholesky.h"
#include "roomwise/mapping/graph/chordal_start.h"
#include "roomwise/mapping/graph/edge_error.h"

namespace roomwise::mapping {
namespace {

using geometry::Matrix6d;
using geometry::RigidTransform;

double cost_of(const IndexedGraph& graph, std::span<const RigidTransform> world_from_node) {
  double sum = 0;
  for (const NumberedEdge& edge : graph.edges) {
    sum += edge_cost(*edge.edge, world_from_node[edge.from], world_from_node[edge.to], edge.kernel);
  }
  return sum;
}

auto segment(Eigen::VectorXd& numbers, std::size_t pose) {
  return numbers.segment<6>(6 * static_cast<Eigen::Index>(pose));
}

// What levenberg_marquardt.h minimises: six variables for each pose that may move.
class PoseGraphProblem {
 public:
  explicit PoseGraphProblem(IndexedGraph& graph)
      : graph_(graph),
        variable_poses_(graph.world_from_node.size() - graph.fixed_pose_count),
        cholesky_(variable_poses_, pairs_of(graph)) {}

  [[nodiscard]] double cost() const { return cost_of(graph_, graph_.world_from_node); }

  void linearize() {
    hessian_.assign(variable_poses_, Matrix6d::Zero());
    off_diagonal_hessian_.clear();
    rhs_.setZero(6 * static_cast<Eigen::Index>(variable_poses_));
    for (const NumberedEdge& edge : graph_.edges) {
      const EdgeEquations equations =
          mapping::linearize(*edge.edge, graph_.world_from_node[edge.from],
                             graph_.world_from_node[edge.to], edge.kernel);
      const bool moves_from = edge.from >= graph_.fixed_pose_count;
      const bool moves_to = edge.to >= graph_.fixed_pose_count;
      if (moves_from) {
        hessian_[edge.from - graph_.fixed_pose_count] += equations.from_hessian;
        segment(rhs_, edge.from - graph_.fixed_pose_count) += equations.from_rhs;
      }
      if (moves_to) {
        hessian_[edge.to - graph_.fixed_pose_count] += equations.to_hessian;
        segment(rhs_, edge.to - graph_.fixed_pose_count) += equations.to_rhs;
      }
      if (moves_from && moves_to) off_diagonal_hessian_.push_back(equations.from_to_hessian);
    }
  }

  [[nodiscard]] std::optional<geometry::DampedStep> solve(double damping) {
    std::vector<Matrix6d> damped = hessian_;
    const Eigen::VectorXd weights = add_damping(damped, damping);
    if (!cholesky_.factorize(damped, off_diagonal_hessian_)) return std::nullopt;
    step_ = rhs_;
    cholesky_.solve(step_);
    return geometry::DampedStep{rhs_.dot(step_) + step_.dot(weights.cwiseProduct(step_)),
                                step_.lpNorm<Eigen::Infinity>()};
  }

  void take_step() {
    before_ = graph_.world_from_node;
    for (std::size_t i = 0; i < variable_poses_; ++i) {
      RigidTransform& pose = graph_.world_from_node[graph_.fixed_pose_count + i];
      pose = retract(pose, segment(step_, i));
    }
  }
  void undo_step() { graph_.world_from_node.swap(before_); }

 private:
  static std::vector<BlockPair> pairs_of(const IndexedGraph& graph) {
    std::vector<BlockPair> pairs;
    const auto fixed = static_cast<std::uint32_t>(graph.fixed_pose_count);
    for (const NumberedEdge& edge : graph.edges) {
      if (edge.from >= fixed && edge.to >= fixed)
        pairs.emplace_back(edge.from - fixed, edge.to - fixed);
    }
    return pairs;
  }

  IndexedGraph& graph_;
  std::size_t variable_poses_;
  BlockCholesky cholesky_;
  std::vector<Matrix6d> hessian_, off_diagonal_hessian_;  // blocks by pose, and by edge
  Eigen::VectorXd rhs_, step_;
  std::vector<RigidTransform> before_;
};

}  // namespace

geometry::MinimizerSummary minimize(IndexedGraph& graph, const PoseGraphOptions& options,
                                    const Interruption& interruption) {
  constexpr double kRounding = 1e-12;  // steps that are so small next to the poses are none
  if (graph.fixed_pose_count == graph.world_from_node.size()) return {};
  if (options.relaxes_start) {
    auto relaxed = chordal_start(graph, interruption);
    if (interruption.interrupted()) return {.termination = geometry::Termination::kInterrupted};
    if (relaxed && cost_of(graph, *relaxed) < cost_of(graph, graph.world_from_node))
      graph.world_from_node = *std::move(relaxed);
  }
  double longest_m = 1;
  for (const RigidTransform& pose : graph.world_from_node)
    longest_m = std::max(longest_m, pose.translation.cwiseAbs().maxCoeff());
  PoseGraphProblem problem(graph);
  // It starts almost undamped: pose graphs are nearly quadratic but so badly conditioned that even
  // light damping takes many iterations to shed.
  return geometry::minimize(problem,
                            {.max_iterations = options.max_iterations,
                             .relative_tolerance = options.relative_tolerance,
                             .min_step_length = kRounding * longest_m,
                             .initial_damping = 1e-8,
                             .min_damping = 1e-12,
                             .max_damping = 1e12},
                            [&] { return !interruption.interrupted(); });
}

}  // namespace roomwise::mapping
