#include "roomwise/mapping/graph/pose_graph_solver.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "roomwise/mapping/graph/block_cholesky.h"
#include "roomwise/mapping/graph/edge_error.h"

namespace roomwise::mapping {
namespace {

using geometry::Matrix6d;
using geometry::RigidTransform;
using geometry::Vector6d;

// Cauchy's kernel, k log(1 + s / k), and its derivatives by s = e^T Omega e.
struct Cost {
  double value = 0;
  double derivative = 1;
  double second_derivative = 0;
};
Cost cost_of(double squares, double kernel) {
  if (kernel == 0) return {squares, 1, 0};
  const double derivative = 1 / (1 + squares / kernel);
  return {kernel * std::log1p(squares / kernel), derivative, -derivative * derivative / kernel};
}

// The cost's quadratic approximation in the steps of the poses that may move, six numbers a pose:
// cost - 2 gradient . step + step^T hessian step.
struct NormalEquations {
  std::vector<Matrix6d> diagonal;  // of the hessian, by pose
  std::vector<Matrix6d> off_diagonal;
  Eigen::VectorXd gradient;  // half of it, downhill
};

class LevenbergMarquardt {
 public:
  explicit LevenbergMarquardt(NumberedGraph& graph)
      : graph_(graph),
        free_count_(graph.world_from_node.size() - graph.fixed),
        cholesky_(free_count_, pairs_of(graph)) {}

  MinimizerSummary run(const PoseGraphOptions& options);

 private:
  static std::vector<BlockPair> pairs_of(const NumberedGraph& graph) {
    std::vector<BlockPair> pairs;
    const auto fixed = static_cast<std::uint32_t>(graph.fixed);
    for (const NumberedEdge& edge : graph.edges) {
      if (edge.from >= fixed && edge.to >= fixed)
        pairs.emplace_back(edge.from - fixed, edge.to - fixed);
    }
    return pairs;
  }

  [[nodiscard]] double cost(const std::vector<RigidTransform>& poses) const;
  void linearize();
  bool factorize(double damping);
  [[nodiscard]] std::vector<RigidTransform> stepped(const Eigen::VectorXd& step) const;

  NumberedGraph& graph_;
  std::size_t free_count_;
  BlockCholesky cholesky_;
  NormalEquations equations_;
  std::vector<Matrix6d> damped_;  // the hessian's diagonal blocks with the damping
};

double LevenbergMarquardt::cost(const std::vector<RigidTransform>& poses) const {
  double sum = 0;
  for (const NumberedEdge& edge : graph_.edges) {
    const Vector6d error = edge_error(edge.edge->from_from_to, poses[edge.from], poses[edge.to]);
    sum += cost_of(error.dot(edge.edge->information * error), edge.kernel).value;
  }
  return sum;
}

void LevenbergMarquardt::linearize() {
  equations_.diagonal.assign(free_count_, Matrix6d::Zero());
  equations_.off_diagonal.clear();
  equations_.gradient.setZero(6 * static_cast<Eigen::Index>(free_count_));
  for (const NumberedEdge& edge : graph_.edges) {
    const RigidTransform& from = graph_.world_from_node[edge.from];
    const RigidTransform& to = graph_.world_from_node[edge.to];
    const RigidTransform& measured = edge.edge->from_from_to;
    const Vector6d error = edge_error(measured, from, to);
    const EdgeJacobians by = edge_jacobians(measured, from, to);
    const Vector6d weighted_error = edge.edge->information * error;
    const double squares = error.dot(weighted_error);
    const Cost cost = cost_of(squares, edge.kernel);
    Matrix6d weight = cost.derivative * edge.edge->information;
    if (cost.second_derivative != 0) {
      // The kernel's second derivative, as far as the weight stays positive semi-definite.
      const double second_derivative =
          std::max(2 * cost.second_derivative, -cost.derivative / squares);
      weight += second_derivative * weighted_error * weighted_error.transpose();
    }
    const Matrix6d from_weight = by.by_from.transpose() * weight;
    const Matrix6d to_weight = by.by_to.transpose() * weight;
    const bool from_moves = edge.from >= graph_.fixed;
    const bool to_moves = edge.to >= graph_.fixed;
    const std::size_t a = edge.from - graph_.fixed;
    const std::size_t b = edge.to - graph_.fixed;
    if (from_moves) {
      equations_.diagonal[a] += from_weight * by.by_from;
      equations_.gradient.segment<6>(6 * static_cast<Eigen::Index>(a)) -=
          cost.derivative * (by.by_from.transpose() * weighted_error);
    }
    if (to_moves) {
      equations_.diagonal[b] += to_weight * by.by_to;
      equations_.gradient.segment<6>(6 * static_cast<Eigen::Index>(b)) -=
          cost.derivative * (by.by_to.transpose() * weighted_error);
    }
    if (from_moves && to_moves) equations_.off_diagonal.emplace_back(from_weight * by.by_to);
  }
}

bool LevenbergMarquardt::factorize(double damping) {
  // Directions about which the edges say nothing are held by a small part of the largest weight.
  constexpr double kMinDamped = 1e-9;
  double largest = 0;
  for (const Matrix6d& block : equations_.diagonal)
    largest = std::max(largest, block.diagonal().maxCoeff());
  damped_ = equations_.diagonal;
  for (Matrix6d& block : damped_)
    block.diagonal() += damping * block.diagonal().cwiseMax(kMinDamped * largest);
  return cholesky_.factorize(damped_, equations_.off_diagonal);
}

std::vector<RigidTransform> LevenbergMarquardt::stepped(const Eigen::VectorXd& step) const {
  std::vector<RigidTransform> poses = graph_.world_from_node;
  for (std::size_t i = 0; i < free_count_; ++i) {
    RigidTransform& pose = poses[graph_.fixed + i];
    pose = retract(pose, step.segment<6>(6 * static_cast<Eigen::Index>(i)));
  }
  return poses;
}

// Levenberg and Marquardt's method with Nielsen's choice of the damping (Madsen, Nielsen and
// Tingleff 2004). It starts almost undamped: pose graphs are nearly quadratic but so badly
// conditioned that even light damping takes many iterations to shed.
MinimizerSummary LevenbergMarquardt::run(const PoseGraphOptions& options) {
  constexpr double kFirstDamping = 1e-8;
  constexpr double kMinDamping = 1e-12;
  constexpr double kMaxDamping = 1e12;
  constexpr double kRounding = 1e-12;  // steps that are so small next to the poses are none
  MinimizerSummary summary;
  double longest_m = 1;
  for (const RigidTransform& pose : graph_.world_from_node)
    longest_m = std::max(longest_m, pose.translation.cwiseAbs().maxCoeff());
  double current = cost(graph_.world_from_node);
  double damping = kFirstDamping;
  double growth = 2;
  bool moved_on = true;
  while (!summary.converged && summary.iterations < options.max_iterations &&
         damping <= kMaxDamping) {
    ++summary.iterations;
    if (std::exchange(moved_on, false)) linearize();
    if (!factorize(damping)) {
      damping *= 10;
      continue;
    }
    Eigen::VectorXd step = equations_.gradient;
    cholesky_.solve(step);
    std::vector<RigidTransform> poses = stepped(step);
    const double changed = cost(poses);
    // With little damping this is g^T H^-1 g: the gradient's size, measured by what it is worth.
    const double predicted_reduction = equations_.gradient.dot(step);
    const bool too_little = predicted_reduction <= options.relative_tolerance * current;
    summary.converged = (too_little && damping <= kFirstDamping) ||
                        step.lpNorm<Eigen::Infinity>() <= kRounding * longest_m;
    if (changed <= current) {
      const double ratio = (current - changed) / predicted_reduction;
      summary.converged |= ratio > 0.5 && damping <= kFirstDamping &&
                           current - changed <= options.relative_tolerance * current;
      damping *= std::clamp(1 - std::pow(2 * ratio - 1, 3), 0.1, 2.0);
      damping = std::max(damping, kMinDamping);
      growth = 2;
      graph_.world_from_node = std::move(poses);
      current = changed;
      moved_on = true;
    } else {
      damping *= growth;
      growth *= 2;
    }
  }
  return summary;
}

}  // namespace

MinimizerSummary minimize(NumberedGraph& graph, const PoseGraphOptions& options) {
  if (graph.fixed == graph.world_from_node.size()) return {0, true};
  return LevenbergMarquardt(graph).run(options);
}

}  // namespace roomwise::mapping
