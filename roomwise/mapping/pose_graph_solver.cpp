#include "roomwise/mapping/pose_graph_solver.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "roomwise/mapping/block_cholesky.h"
#include "roomwise/mapping/edge_error.h"

namespace roomwise::mapping {
namespace {

using geometry::Matrix6d;
using geometry::RigidTransform;
using geometry::Vector6d;

// Cauchy's kernel, k log(1 + s / k), and its derivatives by s = e^T Omega e.
struct Cost {
  double value = 0;
  double slope = 1;
  double bend = 0;
};
Cost cost_of(double squares, double kernel) {
  if (kernel == 0) return {squares, 1, 0};
  const double slope = 1 / (1 + squares / kernel);
  return {kernel * std::log1p(squares / kernel), slope, -slope * slope / kernel};
}

// The cost's quadratic approximation in the steps of the poses that may move, six numbers a pose:
// cost - 2 gradient . step + step^T hessian step.
struct Quadratic {
  std::vector<Matrix6d> diagonal;  // of the hessian, by pose
  std::vector<Matrix6d> off_diagonal;
  Eigen::VectorXd gradient;  // half of it, downhill
};

class Descender {
 public:
  explicit Descender(NumberedGraph& graph)
      : graph_(graph),
        moving_(graph.world_from_node.size() - graph.fixed),
        cholesky_(moving_, pairs_of(graph)) {}

  Descent run(const PoseGraphOptions& options);

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
  std::size_t moving_;
  BlockCholesky cholesky_;
  Quadratic quadratic_;
  std::vector<Matrix6d> damped_;  // the hessian's diagonal blocks with the damping
};

double Descender::cost(const std::vector<RigidTransform>& poses) const {
  double sum = 0;
  for (const NumberedEdge& edge : graph_.edges) {
    const Vector6d error = edge_error(edge.edge->from_from_to, poses[edge.from], poses[edge.to]);
    sum += cost_of(error.dot(edge.edge->information * error), edge.kernel).value;
  }
  return sum;
}

void Descender::linearize() {
  quadratic_.diagonal.assign(moving_, Matrix6d::Zero());
  quadratic_.off_diagonal.clear();
  quadratic_.gradient.setZero(6 * static_cast<Eigen::Index>(moving_));
  for (const NumberedEdge& edge : graph_.edges) {
    const RigidTransform& from = graph_.world_from_node[edge.from];
    const RigidTransform& to = graph_.world_from_node[edge.to];
    const RigidTransform& measured = edge.edge->from_from_to;
    const Vector6d error = edge_error(measured, from, to);
    const EdgeJacobians by = edge_jacobians(measured, from, to);
    const Vector6d weighted_error = edge.edge->information * error;
    const double squares = error.dot(weighted_error);
    const Cost cost = cost_of(squares, edge.kernel);
    Matrix6d weight = cost.slope * edge.edge->information;
    if (cost.bend != 0) {
      // The kernel's second derivative, as far as the weight stays positive semi-definite.
      const double bend = std::max(2 * cost.bend, -cost.slope / squares);
      weight += bend * weighted_error * weighted_error.transpose();
    }
    const Matrix6d from_weight = by.by_from.transpose() * weight;
    const Matrix6d to_weight = by.by_to.transpose() * weight;
    const bool from_moves = edge.from >= graph_.fixed;
    const bool to_moves = edge.to >= graph_.fixed;
    const std::size_t a = edge.from - graph_.fixed;
    const std::size_t b = edge.to - graph_.fixed;
    if (from_moves) {
      quadratic_.diagonal[a] += from_weight * by.by_from;
      quadratic_.gradient.segment<6>(6 * static_cast<Eigen::Index>(a)) -=
          cost.slope * (by.by_from.transpose() * weighted_error);
    }
    if (to_moves) {
      quadratic_.diagonal[b] += to_weight * by.by_to;
      quadratic_.gradient.segment<6>(6 * static_cast<Eigen::Index>(b)) -=
          cost.slope * (by.by_to.transpose() * weighted_error);
    }
    if (from_moves && to_moves) quadratic_.off_diagonal.emplace_back(from_weight * by.by_to);
  }
}

bool Descender::factorize(double damping) {
  // Directions about which the edges say nothing are held by a small part of the largest weight.
  constexpr double kLeastDamped = 1e-9;
  double largest = 0;
  for (const Matrix6d& block : quadratic_.diagonal)
    largest = std::max(largest, block.diagonal().maxCoeff());
  damped_ = quadratic_.diagonal;
  for (Matrix6d& block : damped_)
    block.diagonal() += damping * block.diagonal().cwiseMax(kLeastDamped * largest);
  return cholesky_.factorize(damped_, quadratic_.off_diagonal);
}

std::vector<RigidTransform> Descender::stepped(const Eigen::VectorXd& step) const {
  std::vector<RigidTransform> poses = graph_.world_from_node;
  for (std::size_t i = 0; i < moving_; ++i) {
    RigidTransform& pose = poses[graph_.fixed + i];
    pose = moved(pose, step.segment<6>(6 * static_cast<Eigen::Index>(i)));
  }
  return poses;
}

// Levenberg and Marquardt's method with Nielsen's choice of the damping (Madsen, Nielsen and
// Tingleff 2004). It starts almost undamped: pose graphs are nearly quadratic but so badly
// conditioned that even light damping takes many iterations to shed.
Descent Descender::run(const PoseGraphOptions& options) {
  constexpr double kFirstDamping = 1e-8;
  constexpr double kLeastDamping = 1e-12;
  constexpr double kMostDamping = 1e12;
  constexpr double kRounding = 1e-12;  // steps that are so small next to the poses are none
  Descent descent;
  double longest_m = 1;
  for (const RigidTransform& pose : graph_.world_from_node)
    longest_m = std::max(longest_m, pose.translation.cwiseAbs().maxCoeff());
  double current = cost(graph_.world_from_node);
  double damping = kFirstDamping;
  double growth = 2;
  bool moved_on = true;
  while (!descent.converged && descent.iterations < options.most_iterations &&
         damping <= kMostDamping) {
    ++descent.iterations;
    if (std::exchange(moved_on, false)) linearize();
    if (!factorize(damping)) {
      damping *= 10;
      continue;
    }
    Eigen::VectorXd step = quadratic_.gradient;
    cholesky_.solve(step);
    std::vector<RigidTransform> poses = stepped(step);
    const double changed = cost(poses);
    // With little damping this is g^T H^-1 g: the gradient's size, measured by what it is worth.
    const double foreseen = quadratic_.gradient.dot(step);
    const bool too_little = foreseen <= options.relative_tolerance * current;
    descent.converged = (too_little && damping <= kFirstDamping) ||
                        step.lpNorm<Eigen::Infinity>() <= kRounding * longest_m;
    if (changed <= current) {
      const double ratio = (current - changed) / foreseen;
      descent.converged |= ratio > 0.5 && damping <= kFirstDamping &&
                           current - changed <= options.relative_tolerance * current;
      damping *= std::clamp(1 - std::pow(2 * ratio - 1, 3), 0.1, 2.0);
      damping = std::max(damping, kLeastDamping);
      growth = 2;
      graph_.world_from_node = std::move(poses);
      current = changed;
      moved_on = true;
    } else {
      damping *= growth;
      growth *= 2;
    }
  }
  return descent;
}

}  // namespace

Descent descend(NumberedGraph& graph, const PoseGraphOptions& options) {
  if (graph.fixed == graph.world_from_node.size()) return {0, true};
  return Descender(graph).run(options);
}

}  // namespace roomwise::mapping
